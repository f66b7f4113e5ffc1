"""Runs twins on a python-can bus, in real time, on the calling thread."""
