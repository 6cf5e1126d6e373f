"""Memory: of the field's state, and of the process."""

from __future__ import annotations

import sys
from dataclasses import fields, is_dataclass
from typing import Any

import drjit as dr


def state_bytes(state: Any) -> int:
    """Bytes of all Dr.Jit arrays in dataclasses, lists and dictionaries."""
    if is_dataclass(state):
        return sum(state_bytes(getattr(state, f.name)) for f in fields(state))
    if isinstance(state, dict):
        return sum(map(state_bytes, state.values()))
    if isinstance(state, (list, tuple)):
        return sum(map(state_bytes, state))
    if not dr.is_array_v(state):
        return 0
    flat = dr.ravel(state)
    return int(dr.width(flat) * dr.itemsize_v(flat))


def peak_rss_mb() -> float | None:
    """Most memory this process ever held [MB]; None where the system does not tell."""
    try:
        import resource
    except ImportError:  # Windows
        return None
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e6
