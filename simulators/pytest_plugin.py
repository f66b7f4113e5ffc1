"""pytest fixtures for whoever tests master software."""
