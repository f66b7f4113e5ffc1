"""The command canopen-twin."""
