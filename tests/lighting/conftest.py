"""Makes the helpers of `tests/probes/probing.py` importable, and a backend sure."""

import sys
from pathlib import Path

import pytest

HELPERS = str(Path(__file__).parents[1] / "probes")
if HELPERS not in sys.path:
    sys.path.append(HELPERS)


@pytest.fixture(scope="session", autouse=True)
def some_backend():
    """Whatever is in use already, else the CPU."""
    import mitsuba as mi

    from ddgi.backend import use_backend

    use_backend("llvm" if mi.variant() is None else "auto")
