"""Scenario and bench files as tables: which keys there are, what they mean, and their JSON Schema."""
