"""What the author of a device needs."""
