"""Options that several commands share, as decorators and as the records they fill."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from ddgi.cli.values import Lamp, Numbers, PointLight, Size, Sky, SpotLight, lamp

if TYPE_CHECKING:
    from ddgi.scene.scene import Scene
    from ddgi.settings import RenderSettings

Command = TypeVar("Command", bound=Callable[..., Any])


def settings_options(command: Command) -> Command:
    """What shapes a frame."""
    return _stack(
        command,
        click.option("--preset", default="default", help="Settings to start from: see `ddgi presets`.", show_default=True),
        click.option("--config", type=click.Path(path_type=Path), metavar="FILE.toml", help="Settings from a file."),
        click.option("--set", "assignments", multiple=True, metavar="STAGE.FIELD=VALUE", help="One setting; repeatable."),
        click.option("--seed", type=click.IntRange(0, 0xFFFFFFFF), help="Same seed, same machine: same picture."),
    )


def machine_options(command: Command) -> Command:
    """What computes, and what is said about it."""
    return _stack(
        command,
        click.option("--backend", type=click.Choice(["auto", "llvm", "cuda"]), default="auto", help="CPU or NVIDIA GPU.", show_default=True),
        click.option("--json", "json_file", type=click.Path(path_type=Path), metavar="FILE", help="Write figures to a file."),
        click.option("--debug", is_flag=True, help="Show tracebacks and Mitsuba's own messages."),
    )


def scene_options(command: Command) -> Command:
    """What the camera sees, and lights beyond the scene's own."""
    return _stack(
        command,
        click.option("--size", type=Size(), help="Picture size; by default the scene's."),
        click.option("--camera", metavar="NAME|INDEX", help="Which of the scene's cameras; by default the first."),
        click.option("--look", type=Numbers(6, "FROM,TO"), help="Look from a point to a point: six numbers."),
        click.option("--up", metavar="AXIS|X,Y,Z", help="What is up: x, y, z, -x, ... or a vector."),
        click.option("--near", type=float, metavar="D", help="The camera sees nothing closer than this [m]."),
        click.option("--sun", type=Numbers(3, "AZ,EL,INTENSITY"), help="Add a sun: azimuth and elevation [deg], irradiance [W/m^2]."),
        click.option("--sky", type=Sky(), help="Clear sky with its sun, or an even sky of a radiance."),
        click.option("--env", type=click.Path(path_type=Path), metavar="FILE.hdr|exr", help="Surroundings from a picture."),
        click.option("--point", "points", type=PointLight(), multiple=True, help="Add a point light [m, W/sr]; repeatable."),
        click.option("--spot", "spots", type=SpotLight(), multiple=True, help="Add a spot light: position, target, intensity, cutoff [deg]; repeatable."),
    )


@dataclass
class SceneRequest:
    """The scene options."""

    size: tuple[int, int] | None
    camera: str | None
    look: tuple[float, ...] | None
    up: str | None
    near: float | None
    sun: tuple[float, float, float] | None
    sky: str | tuple[float, ...] | None
    env: Path | None
    points: tuple[Lamp, ...]
    spots: tuple[Lamp, ...]


def open_scene(source: str, request: SceneRequest) -> Scene:
    """Load a scene as asked for. A backend must be in use."""
    from dataclasses import replace

    from ddgi.cli.values import parse_numbers
    from ddgi.scene.camera import with_near
    from ddgi.scene.load import load_scene

    vector = None if request.up is None else parse_numbers(request.up)
    scene = load_scene(
        source,
        camera=request.camera,
        size=request.size,
        up=vector or request.up,
        sun=request.sun,
        sky=request.sky,
        env=request.env,
        lights=[lamp(light) for light in (*request.points, *request.spots)],
    )
    if request.look is not None:
        scene = replace(scene, cameras=(_looking(scene, request.look), *scene.cameras))
    if request.near is not None:
        scene = replace(scene, cameras=tuple(with_near(c, request.near) for c in scene.cameras))
    return scene


def _looking(scene: Scene, look: tuple[float, ...]):
    """A camera from a point to a point, with the lens and picture size of the scene's own."""
    import drjit as dr
    import numpy as np

    from ddgi.scene.camera import look_at

    own = scene.camera
    fov = 60.0 if own.orthographic else float(np.degrees(2 * np.arctan(dr.norm(own.right).numpy()[0])))
    return look_at(look[:3], look[3:], scene.up, fov=min(fov, 170.0), size=own.size, name="look")


def make_settings(preset: str, config: Path | None, assignments: tuple[str, ...], seed: int | None) -> RenderSettings:
    """The settings options as settings."""
    from ddgi.config import load_settings

    extra = () if seed is None else (f"seed={seed}",)
    return load_settings(preset, config, (*assignments, *extra))


def start_backend(name: str, debug: bool) -> str:
    """Choose the backend, and quieten Mitsuba: what matters comes as our own errors and notes."""
    from ddgi.backend import use_backend

    chosen = use_backend(name)
    if not debug:
        import mitsuba as mi

        mi.set_log_level(mi.LogLevel.Error)
    return chosen


def _stack(command: Command, *options: Callable[[Any], Any]) -> Command:
    for option in reversed(options):
        command = option(command)
    return command
