"""A CANopen slave: its dictionary, and the services of CiA 301 and 305 beside it."""
