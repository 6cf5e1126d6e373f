"""The LLVM that compiles our kernels is the one the package chose."""

import os
import subprocess
import sys

import drjit as dr
import pytest

from ddgi.backend import LLVM_MINIMUM, use_backend

ASK = "from ddgi.backend import use_backend; use_backend('llvm'); import drjit; print(drjit.detail.llvm_version()[0])"


def test_the_library_in_use_is_new_enough():
    """Dr.Jit loads libLLVM when it is imported: choosing one later changes nothing."""
    if use_backend() != "llvm":
        pytest.skip("another backend is in use")
    assert dr.detail.llvm_version()[0] >= LLVM_MINIMUM


def test_a_fresh_process_uses_the_library_we_ship():
    environment = {k: v for k, v in os.environ.items() if k != "DRJIT_LIBLLVM_PATH"}
    done = subprocess.run(
        [sys.executable, "-c", ASK], env=environment, capture_output=True, text=True, check=True, timeout=120
    )
    assert int(done.stdout) >= LLVM_MINIMUM
