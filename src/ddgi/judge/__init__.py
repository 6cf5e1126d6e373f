"""How wrong the light is, and compared with what."""
