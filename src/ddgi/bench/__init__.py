"""Measurements: time per stage, kernel launches, memory, and what the machine could do at best."""
