"""Digital twins of CANopen slaves: the dictionaries and behaviour of real devices, without the devices."""
