"""The project's own simulators, which are none of canopen-twins."""
