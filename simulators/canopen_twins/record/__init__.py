"""Records of runs: what was on the bus and why, to be lived through again and compared."""
