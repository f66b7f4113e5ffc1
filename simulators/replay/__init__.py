"""Replays a scenario."""
