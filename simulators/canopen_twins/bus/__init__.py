"""A CAN bus: frames, their identifiers, the clock, and whatever carries them."""
