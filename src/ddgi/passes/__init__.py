"""From the field and the scene to a picture."""
