"""The POWER CHARGER without its bus: everything in units, nothing of CAN."""
