"""Choosing the backend: in processes of their own, as one keeps its first choice."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from ddgi.backend import use_backend
from ddgi.errors import BackendError


def in_new_process(code: str, **environment: str) -> str:
    """Runs code after `from ddgi.backend import *`; the last line of its output."""
    lines = (
        "from ddgi import backend",
        "from ddgi.backend import use_backend",
        "from ddgi.errors import BackendError",
        code,
    )
    done = subprocess.run(
        [sys.executable, "-c", "\n".join(lines)], capture_output=True, text=True, env=os.environ | environment
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def refused(call: str, before: str = "", **environment: str) -> str:
    """What the BackendError of a call says."""
    return in_new_process(
        f"{before}\ntry:\n    {call}\nexcept BackendError as error:\n    print(error)", **environment
    )


def test_says_what_is_in_use(backend):
    assert use_backend("auto") == backend


def test_one_process_one_backend(backend):
    other = {"llvm": "cuda", "cuda": "llvm"}[backend]
    with pytest.raises(BackendError, match=f"the {backend} backend is already in use"):
        use_backend(other)


def test_unknown_backend():
    with pytest.raises(BackendError, match="unknown backend 'metal': choose auto, llvm or cuda"):
        use_backend("metal")


def test_another_variant_is_in_use():
    text = refused("use_backend()", "import mitsuba as mi; mi.set_variant('scalar_rgb')")
    assert "scalar_rgb is in use" in text


def test_path_that_does_not_exist():
    text = refused("use_backend('llvm')", DRJIT_LIBLLVM_PATH="/none/libLLVM.so")
    assert "DRJIT_LIBLLVM_PATH points to /none/libLLVM.so, which does not load" in text
    assert len(text.splitlines()) == 1


def test_path_that_is_no_library(tmp_path):
    text_file = Path(tmp_path, "libLLVM.so")
    text_file.write_text("not a library")
    assert "does not load as libLLVM" in refused("use_backend('llvm')", DRJIT_LIBLLVM_PATH=str(text_file))


def test_no_llvm_at_all():
    hide = "backend._bundled_llvm = lambda: None; backend.ctypes.util.find_library = lambda name: None"
    hide += "; import os; os.environ.pop('DRJIT_LIBLLVM_PATH', None)"
    assert "libLLVM not found: install it with" in refused("use_backend('llvm')", hide)


def test_llvm_too_old():
    old = "backend._llvm_version = lambda library: 14"
    assert "older than LLVM 16" in refused("use_backend('llvm')", old)


def test_no_gpu():
    assert "use --backend llvm" in refused("use_backend('cuda')", "backend._gpu_present = lambda: False")


def test_no_optix():
    code = "backend._gpu_present = lambda: True; backend._loads = lambda path: None"
    assert "without OptiX" in refused("use_backend('cuda')", code)


def test_auto_falls_back_to_the_cpu():
    assert in_new_process("backend._gpu_present = lambda: False; print(use_backend())") == "llvm"


@pytest.mark.cuda
def test_cuda_starts():
    assert in_new_process("print(use_backend('cuda'))") == "cuda"


@pytest.mark.parametrize("first", ["ddgi", "ddgi.frame", "ddgi.scene.load", "ddgi.cli"])
def test_dr_jit_gets_an_llvm_that_is_new_enough_whatever_is_imported_first(first):
    """Dr.Jit loads LLVM at its own import; the path must be set by then."""
    code = (
        f"import {first}, ddgi; ddgi.use_backend('llvm'); import drjit; print(drjit.detail.llvm_version()[0])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert int(done.stdout) >= 16


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="cores cannot be chosen here")
def test_openexr_files_on_a_single_core(tmp_path):
    """Mitsuba alone waits forever for a thread that is not there."""
    code = (
        "import os; os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})\n"
        "import ddgi; from ddgi.backend import use_backend; use_backend('llvm')\n"
        "import mitsuba as mi, numpy as np\n"
        "mi.Bitmap(np.zeros((4, 4, 3), np.float32)).write('a.exr'); print(mi.Bitmap('a.exr').size())"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, timeout=60
    )
    assert done.stdout.strip() == "[4, 4]", done.stderr
