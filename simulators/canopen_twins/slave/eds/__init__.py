"""Files that describe a dictionary: EDS and DCF (CiA 306), XDD and XDC (CiA 311)."""
