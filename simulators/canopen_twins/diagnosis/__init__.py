"""Frames and refusals in words, with the section of the manual."""
