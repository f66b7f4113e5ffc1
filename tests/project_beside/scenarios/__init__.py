"""The project's own scenarios."""
