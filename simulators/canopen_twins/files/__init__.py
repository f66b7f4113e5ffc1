"""YAML files as values that know their place: what is wrong is told with file, line and column."""
