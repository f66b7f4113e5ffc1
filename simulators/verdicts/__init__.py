"""Verdicts for programs: JUnit XML, JSON, and flat properties of a test."""
