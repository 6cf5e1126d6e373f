"""One backend for the whole run (Mitsuba's types belong to the first that is chosen), and the command line."""

import os

import pytest

import ddgi  # noqa: F401 - before any test imports Dr.Jit, which then loads the right libLLVM


def pytest_addoption(parser: pytest.Parser) -> None:
    """`--backend cuda` runs the tests on the GPU."""
    parser.addoption("--backend", choices=("llvm", "cuda"), default="llvm", help="what computes")


@pytest.fixture(scope="session", autouse=True)
def backend(pytestconfig: pytest.Config) -> str:
    """Choose what computes before any test makes an array, unless something is in use already."""
    import drjit as dr
    import mitsuba as mi

    from ddgi.backend import use_backend

    if "PYTEST_XDIST_WORKER" in os.environ:  # processes share the cores
        dr.set_thread_count(2)
    return use_backend(pytestconfig.getoption("--backend") if mi.variant() is None else "auto")


@pytest.fixture(autouse=True)
def _skip_without_gpu(request: pytest.FixtureRequest) -> None:
    """Tests marked `cuda` need a GPU that can trace rays."""
    from ddgi.backend import optix_problem

    if request.node.get_closest_marker("cuda") and optix_problem() is not None:
        pytest.skip("no NVIDIA GPU with OptiX")


@pytest.fixture
def run(capfd):
    """The command in this process: (exit code, stdout, stderr)."""
    from ddgi.cli import main

    def call(*arguments: str) -> tuple[int, str, str]:
        code = main(list(map(str, arguments)))
        out, err = capfd.readouterr()
        return code, out, err

    return call


@pytest.fixture
def refused(run, tmp_path, monkeypatch):
    """Runs the command where it must fail; the one line it prints."""
    monkeypatch.chdir(tmp_path)

    def call(*arguments: str, code: int = 1) -> str:
        before = sorted(tmp_path.rglob("*"))
        found, out, err = run(*arguments)
        assert (found, out) == (code, "")
        *progress, last = err.splitlines()
        assert all(line.endswith(" ...") for line in progress), err  # what a slow machine is doing
        assert last.startswith("ddgi: error: ")
        assert sorted(tmp_path.rglob("*")) == before, "nothing is left behind"
        return last

    return call
