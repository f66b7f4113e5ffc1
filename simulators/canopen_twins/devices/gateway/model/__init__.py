"""The governor, its engine and its gateway as two machines on a link, without any CAN."""
