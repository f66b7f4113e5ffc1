"""Many runs of one contract: the search for what breaks a master."""
