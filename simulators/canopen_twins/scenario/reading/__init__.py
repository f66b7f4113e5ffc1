"""What the tables of a file mean: names are looked up, steps tried, everything wrong is told."""
