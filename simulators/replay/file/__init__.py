"""Scenario and bench files as tables: the keys there are, what they mean, their JSON Schema."""
