"""Measure quality, study by study, into docs/results/NAME.json; `results_page.py` makes the page of them.

    python benchmarks/studies.py                 # lists the studies
    python benchmarks/studies.py quality maps    # runs some
    python benchmarks/studies.py all

References are kept between runs (`ddgi compare` shares them). Scenes of files lie in ../shared/scenes,
if at all; without them their rows are left out, and said to be.
"""

from __future__ import annotations

import json
import os
import platform
import subprocess
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import click

import ddgi
from ddgi.backend import use_backend
from ddgi.config import load_settings
from ddgi.judge.compare import Comparison, compare
from ddgi.judge.sheet import sheet
from ddgi.judge.trial import Trial
from ddgi.output import save_display

HERE = Path(__file__).parents[1]
RESULTS, PICTURES = HERE / "docs" / "results", HERE / "docs" / "pictures"
FILES = HERE.parent / "shared" / "scenes"
SIZE = (320, 180)


@dataclass(frozen=True)
class View:
    """A scene, how it is looked at, and how good its reference must be."""

    scene: str
    camera: str | None = None
    materials: str = "full"
    size: tuple[int, int] = SIZE
    target: float = 0.05

    @property
    def name(self) -> str:
        """What the page calls it."""
        return self.scene if self.camera is None else f"{self.scene}, {self.camera}"

    def load(self) -> ddgi.Scene | None:
        """The scene; None where its file is not there."""
        source: str | Path = self.scene
        if (FILES / self.scene).is_dir() or self.scene in FROM_FILES:
            source = FILES / self.scene / "scene_mi3.xml"
            if not source.exists():
                return None
        return ddgi.load_scene(source, camera=self.camera, size=self.size, materials=self.materials)


FROM_FILES = ("staircase2", "veach-ajar", "veach-bidir", "classroom")
CLOSED = tuple(
    View(name, materials="diffuse")
    for name in ("cornell", "cornell-point", "color-boxes", "ceiling-hole", "statue-box", "dragon-box")
)
LARGE = (
    View("two-rooms", materials="diffuse", target=0.1),
    View("house", "open", target=0.1),
    View("courtyard", target=0.2),
    View("courtyard", "gallery", target=0.2),
    View("cathedral", target=0.2),
    View("living-room", target=0.2),
    View("forest", target=0.2),
    View("staircase2", target=0.2),
    View("classroom", target=0.2),
    # Smaller, as their references take hours; at so few pixels the update is most of a frame.
    View("veach-ajar", size=(192, 108), target=0.2),
    View("veach-bidir", size=(192, 108), target=0.2),
)


def trials(*texts: str, preset: str = "default") -> list[Trial]:
    """Configurations from `name: stage.field=value; ...`; the name alone is the preset."""
    found = []
    for text in texts:
        name, _, changes = text.partition(":")
        sets = [c.strip() for c in changes.split(";") if c.strip()]
        found.append(Trial(name.strip(), load_settings(preset, None, sets)))
    return found


def judged(
    views: Sequence[View], configurations: Sequence[Trial], *, seconds: float = 30, rivals: bool = False,
    frames: int = 64, pictures: str | None = None,
) -> list[dict[str, Any]]:  # fmt: skip
    """Every view under every configuration."""
    rows = []
    for view in views:
        scene = view.load()
        if scene is None:
            print(f"{view.name}: not here, left out", flush=True)
            continue
        found = compare(
            scene, configurations, frames=frames, target=view.target, most_seconds=seconds, rivals=rivals
        )
        figures = found.figures()
        for configuration in figures["configurations"].values():
            del configuration["settings"]  # this file and the commit say them
        rows.append({"name": view.name, "materials": view.materials} | figures)
        print(view.name, f"{found.judged[0].difference.flip_mean:.4f}", f"valid {found.valid}", flush=True)
        if pictures:
            _picture(found, f"{pictures}-{view.scene}")
    return rows


def _picture(found: Comparison, name: str) -> None:
    """Half as wide and high, to keep the repository small."""
    page = sheet(found)
    height, width = (n // 2 * 2 for n in page.shape[:2])
    small = page[:height, :width].reshape(height // 2, 2, width // 2, 2, 3).mean((1, 3))
    PICTURES.mkdir(exist_ok=True)
    save_display(PICTURES / f"{name}.png", small.astype("uint8"))


PICTURED = ("statue-box", "cathedral", "living-room")
"""Scenes whose sheets docs/ shows."""


def quality() -> Any:
    """Every scene with the default, beside a path tracer of equal time, and with the preset for stills."""
    rows = []
    for view in (*CLOSED, *LARGE):
        pictures = "compare" if view.scene in PICTURED else None
        both = trials("default") + trials("fine", preset="fine")
        rows += judged([view], both, rivals=True, pictures=pictures)
    return rows


def presets() -> Any:
    """Every preset; those of the papers with the warm-up switched on too, so that converged light is compared."""
    configurations = [Trial(name, ddgi.RenderSettings.preset(name)) for name in ("default", "fine")]
    for name in ("scale", "blog", "ctu", "mff", "classic"):
        configurations += [Trial(name, load_settings(name, None, ["blend.warm_up=12"]))]
    views = (
        View("cornell-point", materials="diffuse"),
        View("statue-box", materials="diffuse"),
        View("room-with-door", "room", materials="diffuse", target=0.1),
        View("two-rooms", materials="diffuse", target=0.1),
        View("courtyard", target=0.2),
    )
    return judged(views, configurations)


def ablation() -> Any:
    """CTU Fig. 7.1: the weights of the query one by one, 16 x 8 x 16 probes."""
    none = "query.wrap=off; query.visibility=false; query.bias=off; query.crush=0; query.sight=maps; relocation.method=off; grid.counts=[16,8,16]"
    wrap = none.replace("query.wrap=off; ", "")
    visible = wrap.replace("query.visibility=false; ", "")
    biased = visible.replace("query.bias=off; ", "")
    crushed = biased.replace("query.crush=0; ", "")
    configurations = trials(
        f"none: {none}", f"wrap: {wrap}", f"and Chebyshev: {visible}", f"and bias: {biased}",
        f"and crush: {crushed}", "and sight: relocation.method=off; grid.counts=[16,8,16]",
        "and relocation: grid.counts=[16,8,16]",
    )  # fmt: skip
    view = View("room-with-door", "room", materials="diffuse", target=0.1)
    return judged([view], configurations, pictures="ablation")


def maps() -> Any:
    """MFF Table 4.5: map resolutions against error and memory."""
    sizes = [(8, d) for d in (2, 4, 8, 16, 32, 64)] + [(i, 16) for i in (2, 4, 12, 16, 32)]
    configurations = [
        *trials(*(f"{i}x{d}: volume.irradiance_size={i}; volume.distance_size={d}" for i, d in sizes))
    ]
    return judged(
        [View("two-rooms", materials="diffuse", target=0.1), View("cornell-point", materials="diffuse")],
        configurations,
    )


def grids() -> Any:
    """CTU Table 7.1: grid against map size, in a closed box with two occluders."""
    configurations = trials(
        *(
            f"{x}x{y}x{z} {n}: grid.counts=[{x},{y},{z}]; volume.irradiance_size={n}"
            for x, y, z in ((2, 2, 2), (4, 2, 4), (4, 4, 4), (8, 8, 8))
            for n in (2, 8, 16, 32)
        )
    )
    return judged([View("occluder-box", materials="diffuse")], configurations)


CONSTANTS = (
    "default",
    "wrap offset 0.2: query.wrap_offset=0.2",
    "wrap of CTU: query.wrap=wrap",
    "sharp wrap: query.wrap=sharp",
    "bias scale 0.3: query.bias_scale=0.3",
    "bias of CTU: query.bias=ctu; query.bias_scale=0.25",
    "bias of MFF: query.bias=mff; query.bias_scale=0.25",
    "gamma 5: blend.gamma=5",
    "square-root blending: query.sqrt_blending=true",
    "no crush: query.crush=0",
    "Chebyshev exponent 1: query.chebyshev_exponent=1",
    "visibility floor 0.05: query.visibility_floor=0.05",
    "hidden by maps alone: query.sight=maps",
    "hidden by maps and cells: query.sight=cells",
    "probes in their places: relocation.method=off",
    "placed as SCALE: relocation.method=scale; relocation.iterations=5; relocation.clearance=0.15",
    "placed as MFF: relocation.method=mff; relocation.iterations=50; relocation.clearance=0.15",
    "weights follow moves: query.follow_moved=true",
    "long distances rejected: blend.long_distances=reject",
    "long distances kept: blend.long_distances=off",
    "back faces at 0: gather.back_face_distance=0",
    "lamps left to the field: direct.area=field",
    "texels not fitted: blend.fit_texels=false",
    "running mean plain: blend.recency=1",
    "warm-up of 8: blend.warm_up=8",
    "two surfaces a path: gather.path_length=2",
    "8² irradiance: volume.irradiance_size=8",
    "16² irradiance: volume.irradiance_size=16",
    "no light paths: rays.from_lamps=0",
    "32 light paths: rays.from_lamps=32",
    "no contact: contact.hits=0; contact.pixels=0",
    "contact in hits alone: contact.pixels=0",
    "8² distances: volume.distance_size=8",
    "64 rays: rays.per_probe=64",
    "256 rays: rays.per_probe=256",
)

SHOWN = (
    "default", "sharp wrap", "gamma 5", "long distances rejected", "texels not fitted", "no light paths", "no contact",
    "64 rays",
)  # fmt: skip
"""Constants whose pictures docs/ shows."""

NOT_SWEPT = ("cornell-point", "house, open", "courtyard, gallery", "veach-bidir")
"""Views that others stand for: a sweep takes minutes a view."""


def constants() -> Any:
    """The constants on which the papers disagree, one changed at a time."""
    room = View("room-with-door", "room", materials="diffuse", target=0.1)
    views = [v for v in (*CLOSED, room, *LARGE) if v.name not in NOT_SWEPT]
    shown = [c for c in CONSTANTS if c.partition(":")[0] in SHOWN]
    judged([CLOSED[2]], trials(*shown), frames=32, seconds=0, pictures="constants")
    return judged(views, trials(*CONSTANTS), frames=32, seconds=0)


STUDIES: dict[str, Callable[[], Any]] = {
    study.__name__: study for study in (quality, presets, ablation, maps, grids, constants)
}


def machine() -> dict[str, Any]:
    """Where and with what something was measured."""
    commit = subprocess.run(
        ["git", "-C", str(HERE), "describe", "--always", "--dirty"],
        capture_output=True,
        text=True,
        check=False,
    ).stdout.strip()
    return {
        "commit": commit,
        "processor": f"{platform.machine()}, {os.cpu_count()} CPUs",
        "python": platform.python_version(),
        "backend": use_backend(),
    } | {name: version(name) for name in ("mitsuba", "drjit")}


@click.command()
@click.argument("names", nargs=-1)
def main(names: tuple[str, ...]) -> None:
    """Run studies by name."""
    if not names:
        for name, study in STUDIES.items():
            print(f"{name:<10} {study.__doc__}")
    for name in STUDIES if names == ("all",) else names:
        if name not in STUDIES:
            raise click.UsageError(f"no study {name!r}: there are {', '.join(STUDIES)}")
        RESULTS.mkdir(exist_ok=True)
        found = {"machine": machine(), "rows": STUDIES[name]()}
        (RESULTS / f"{name}.json").write_text(json.dumps(found, indent=1, allow_nan=False) + "\n")


if __name__ == "__main__":
    main()
