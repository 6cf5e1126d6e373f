"""The package from outside: its names, the README's example, and what importing costs."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import ddgi

README = Path(__file__).parents[1] / "README.md"
HEAVY = ("mitsuba", "drjit", "numpy", "pydantic", "tomlkit")


def python(code: str) -> str:
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return done.stdout


@pytest.mark.parametrize("name", ddgi.__all__)
def test_public_names_exist_and_are_listed(name):
    assert getattr(ddgi, name) is not None
    assert name in dir(ddgi)


def test_unknown_names_are_attribute_errors():
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = ddgi.nothing


@pytest.mark.parametrize("module", ["ddgi", "ddgi.cli", "ddgi.errors", "ddgi.scene.library"])
def test_importing_stays_light(module):
    loaded = python(f"import sys, {module}; print(*[m for m in {HEAVY} if m in sys.modules])")
    assert loaded.split() == []


@pytest.mark.slow
def test_readme_example_works(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code = re.search(r"```python\n(.*?)```", README.read_text(), re.DOTALL).group(1)
    small = code.replace('"cornell")', '"cornell", size=(48, 32))').replace("range(64)", "range(12)")
    assert small != code
    names = {}
    exec(small, names)
    assert (tmp_path / "cornell.png").stat().st_size > 500
    image = names["frame"].numpy()
    assert image.shape == (32, 48, 3)
    assert np.isfinite(image).all()
    assert image.mean() > 0.01
