"""Twins in real time, on buses of python-can."""
