"""Light leaving a surface, from the lights alone."""
