"""Choose CPU or GPU, once per process.

Mitsuba keeps array types per variant, so a process stays with its first choice. On Linux the
LLVM library comes with the `karellen-llvm-core` package and is found through its metadata.
"""

from __future__ import annotations

import ctypes
import ctypes.util
import os
import sys
from importlib import metadata
from pathlib import Path

from ddgi.errors import BackendError

VARIANTS = {"llvm": "llvm_ad_rgb", "cuda": "cuda_ad_rgb"}
LLVM_MINIMUM = 16
"""Dr.Jit 1.5 emits intrinsics that older versions abort on."""

LEAST_THREADS = 2
"""OpenEXR files are read and written on a thread beside the first: on a single core Mitsuba waits for it forever."""

_LLVM_ADVICE = {
    "linux": "install it with: pip install karellen-llvm-core, or set DRJIT_LIBLLVM_PATH",
    "darwin": "install it with: brew install llvm, then set DRJIT_LIBLLVM_PATH to its libLLVM.dylib",
    "win32": "install LLVM from llvm.org, then set DRJIT_LIBLLVM_PATH to its LLVM-C.dll",
}


def use_backend(name: str = "auto") -> str:
    """Choose what computes: the CPU through LLVM, or an NVIDIA GPU through CUDA and OptiX.

    The first call in a process decides; every function of this package that needs a backend
    calls it with "auto".

    Args:
        name: "llvm", "cuda", or "auto" (the GPU where one can trace rays, else the CPU).

    Returns:
        "llvm" or "cuda".

    Raises:
        BackendError: LLVM or OptiX is missing or too old, or another backend is in use.
    """
    if name not in ("auto", *VARIANTS):
        raise BackendError(f"unknown backend {name!r}: choose auto, llvm or cuda")
    mi = sys.modules.get("mitsuba")
    active = None if mi is None else mi.variant()
    if active is not None:
        name = _keep(active, name)  # the caller's own choice
        _provide_threads()
        return name
    if name == "auto":
        name = "cuda" if optix_problem() is None else "llvm"
    # Before Dr.Jit is imported: it would complain in its own words, and on its own output.
    problem = optix_problem() if name == "cuda" else llvm_problem()
    if problem:
        raise BackendError(problem)
    _start(name)
    _provide_threads()
    return name


def point_to_llvm() -> None:
    """Tell Dr.Jit where libLLVM is, unless the user did or Dr.Jit has been imported already.

    Dr.Jit loads LLVM while it is imported and never again. Without this it takes the system's,
    which may be too old: versions before 16 abort the process ("Cannot select: fminimum").
    """
    if "drjit" not in sys.modules and "DRJIT_LIBLLVM_PATH" not in os.environ and (path := _bundled_llvm()):
        os.environ["DRJIT_LIBLLVM_PATH"] = path


def _start(name: str) -> None:
    """Set the variant and try it."""
    import mitsuba as mi

    try:
        mi.set_variant(VARIANTS[name])
        if problem := _loaded_llvm_problem(name):
            raise RuntimeError(problem)
        _prove(mi)
    except Exception as error:  # Dr.Jit raises bare exceptions when a library does not initialise
        raise BackendError(
            f"the {name} backend does not start: {str(error).strip().splitlines()[0]}"
        ) from error


def _provide_threads() -> None:
    import drjit as dr

    if dr.thread_count() < LEAST_THREADS:
        dr.set_thread_count(LEAST_THREADS)


def _loaded_llvm_problem(name: str) -> str | None:
    """What is wrong with the LLVM that Dr.Jit has loaded, if it is the one that computes."""
    import drjit as dr

    if name != "llvm" or (version := dr.detail.llvm_version()[0]) >= LLVM_MINIMUM:
        return None
    return (
        f"Dr.Jit has loaded LLVM {version}, it needs {LLVM_MINIMUM} or later; "
        "import ddgi before mitsuba and drjit, or set DRJIT_LIBLLVM_PATH"
    )


def _keep(active: str, name: str) -> str:
    """The backend already chosen, or an error if it is unusable or `name` asks for another."""
    current = next((short for short, variant in VARIANTS.items() if variant == active), None)
    if current is None:
        raise BackendError(
            f"Mitsuba's variant {active} is in use; ddgi needs {' or '.join(VARIANTS.values())}"
        )
    if name not in ("auto", current):
        raise BackendError(f"the {current} backend is already in use; start a new process to use {name}")
    if problem := _loaded_llvm_problem(current):
        raise BackendError(problem)
    return current


def _prove(mi) -> None:
    """Run one small kernel and one ray, so that a broken library fails here and not in a frame."""
    import drjit as dr

    scene = mi.load_dict({"type": "scene", "shape": {"type": "rectangle"}})
    ray = mi.Ray3f(mi.Point3f(0, 0, 1), mi.Vector3f(0, 0, dr.opaque(mi.Float, -1)))
    if not dr.all(scene.ray_test(ray)):
        raise RuntimeError("a ray that must hit missed")


def _gpu_present() -> bool:
    return _loads("nvcuda.dll" if sys.platform == "win32" else "libcuda.so.1") is not None


def optix_problem() -> str | None:
    """What keeps the GPU backend from starting, if anything."""
    if not _gpu_present():
        return "no NVIDIA driver found (libcuda.so.1): use --backend llvm"
    library = "nvoptix.dll" if sys.platform == "win32" else "libnvoptix.so.1"
    if _loads(library) is None:
        return (
            f"the NVIDIA driver comes without OptiX ({library}), so the GPU cannot trace: use --backend llvm"
        )
    return None


def llvm_problem() -> str | None:
    """What keeps the CPU backend from starting, if anything."""
    if "drjit" in sys.modules:
        return None  # it has made its choice; `_start` looks at the version
    advice = _LLVM_ADVICE.get(sys.platform, "set DRJIT_LIBLLVM_PATH to libLLVM")
    point_to_llvm()
    path = os.environ.get("DRJIT_LIBLLVM_PATH") or ctypes.util.find_library("LLVM")
    if path is None:
        return f"libLLVM not found: {advice}"
    library = _loads(path)
    if library is None:  # what `find_library` finds does load
        return f"DRJIT_LIBLLVM_PATH points to {path}, which does not load as libLLVM: {advice}"
    if _llvm_version(library) < LLVM_MINIMUM:
        return f"{path} is older than LLVM {LLVM_MINIMUM}: {advice}"
    return None


def _bundled_llvm() -> str | None:
    """Path of libLLVM inside the karellen-llvm-core package, if that is installed."""
    try:
        files = metadata.files("karellen-llvm-core") or []
    except metadata.PackageNotFoundError:
        return None
    found = [f for f in files if f.name.startswith("libLLVM.so")]
    paths = [Path(str(f.locate())).resolve() for f in found]
    # Wheels that place data under the prefix record it relative to site-packages; ask the prefix too.
    paths += [Path(sys.prefix, "lib", f.name) for f in found]
    return next((str(p) for p in paths if p.is_file()), None)


def _llvm_version(library: ctypes.CDLL) -> int:
    """Major version; LLVM states it since 16, so a library that does not is older."""
    if not hasattr(library, "LLVMGetVersion"):
        return 0
    major = ctypes.c_uint()
    library.LLVMGetVersion(ctypes.byref(major), None, None)
    return major.value


def _loads(path: str) -> ctypes.CDLL | None:
    try:
        return ctypes.CDLL(path)
    except OSError:
        return None
