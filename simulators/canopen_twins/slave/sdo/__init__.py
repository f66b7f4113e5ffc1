"""SDO server: expedited, segmented and block transfers (CiA 301, 7.2.4)."""
