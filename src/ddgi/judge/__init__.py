"""How a result is judged: against a reference, and over time."""
