"""A CAN bus over TCP: the protocol of socketcand, whoever serves it and whoever joins it."""
