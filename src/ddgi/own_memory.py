"""Tables in Dr.Jit's own memory, so that any table of the same size takes the place of another.

A NumPy array lent to Dr.Jit lies where NumPy put it, and a table of one number becomes a constant; a
recording depends on both, and new values would have to be recorded anew.
"""

from __future__ import annotations

import drjit as dr
import mitsuba as mi
import numpy as np


def own(values: np.ndarray) -> mi.Float:
    """A table of at least one number, flat: aligned, and never compiled in."""
    lent = mi.Float(np.asarray(values, np.float32).ravel())
    table = lent + dr.opaque(
        mi.Float, 0
    )  # computed, so written to memory of its own; by way of a list it took seconds
    dr.make_opaque(table)
    return table


def own_numbers(values: np.ndarray) -> mi.UInt32:
    """Likewise a table of whole numbers, 0 or more."""
    table = mi.UInt32(np.asarray(values).astype(np.uint32).ravel()) + dr.opaque(mi.UInt32, 0)
    dr.make_opaque(table)
    return table
