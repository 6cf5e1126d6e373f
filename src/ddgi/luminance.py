"""Luminance of linear Rec.709: how bright a colour looks."""

import numpy as np

LUMINANCE = np.array([0.212671, 0.715160, 0.072169], np.float32)
"""Weights of red, green and blue, with the digits that Mitsuba uses."""
