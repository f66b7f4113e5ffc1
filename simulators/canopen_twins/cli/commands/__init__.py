"""The commands of canopen-twin: each takes the parsed options and returns an exit code."""
