"""Heinzmann CANopen Gateway in front of a digital governor (manual DG 04 005-e / 07-04)."""
