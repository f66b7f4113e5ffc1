"""Twins in simulated time."""
