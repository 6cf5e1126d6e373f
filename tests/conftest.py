"""One backend for the whole run: Mitsuba's types belong to the first that is chosen."""

import pytest

import ddgi  # noqa: F401 - before any test imports Dr.Jit, which then loads the right libLLVM


@pytest.fixture(scope="session", autouse=True)
def backend() -> str:
    """Choose the CPU before any test makes an array, unless something is in use already."""
    import mitsuba as mi

    from ddgi.backend import use_backend

    return use_backend("llvm" if mi.variant() is None else "auto")


@pytest.fixture(autouse=True)
def _skip_without_gpu(request: pytest.FixtureRequest) -> None:
    """Tests marked `cuda` need a GPU that can trace rays."""
    from ddgi.backend import optix_problem

    if request.node.get_closest_marker("cuda") and optix_problem() is not None:
        pytest.skip("no NVIDIA GPU with OptiX")
