"""Cold and warm start: from the start of the process to the written picture."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

from ddgi.errors import DDGIError

CACHES = ("DRJIT_CACHE_DIR", "CUDA_CACHE_PATH", "OPTIX_CACHE_PATH")
"""Where compiled kernels are kept."""


def start_seconds(arguments: Sequence[str]) -> tuple[float, float]:
    """(cold, warm): `ddgi render` with these arguments, with an empty kernel cache and once more.

    Raises:
        DDGIError: The rendering failed; says how.
    """
    with TemporaryDirectory() as folder:
        environment = os.environ | {name: str(Path(folder, name.lower())) for name in CACHES}
        for name in CACHES:
            Path(environment[name]).mkdir()
        picture = str(Path(folder, "picture.png"))
        command = [sys.executable, "-m", "ddgi", "render", *arguments, "-o", picture]
        return _seconds(command, environment), _seconds(command, environment)


def _seconds(command: Sequence[str], environment: dict[str, str]) -> float:
    start = perf_counter()
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    elapsed = perf_counter() - start
    if done.returncode:
        raise DDGIError(
            f"the start could not be timed: {(done.stderr.strip() or 'it crashed').splitlines()[-1]}"
        )
    return elapsed
