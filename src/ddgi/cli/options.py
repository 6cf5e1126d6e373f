"""Options that several commands share; `ddgi.cli.request` has the records they fill."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click

from ddgi.cli.request import SceneRequest, SettingsRequest
from ddgi.cli.values import Ceiling, Finite, Numbers, Size, Sky, SpotLight, Up

Command = TypeVar("Command", bound=Callable[..., Any])
Option = Callable[[Any], Any]

FILE = click.Path(path_type=Path)

SCENE_OPTIONS: tuple[Option, ...] = (
    click.option("--size", type=Size(), help="Picture size; by default the scene's."),
    click.option("--camera", metavar="NAME|INDEX", help="Which of the scene's cameras; by default the first."),
    click.option("--look", type=Numbers(6, "FROM,TO"), help="Look from a point to a point: six numbers."),
    click.option("--up", type=Up(), help="What is up in the scene."),
    click.option("--near", type=float, metavar="D", help="The camera, and only it, sees nothing closer than this [m]."),
    click.option("--sun", type=Numbers(3, "AZ,EL,INTENSITY"), help="Add a sun: azimuth, elevation [deg], irradiance [W/m^2]."),
    click.option("--sky", type=Sky(), help="A clear sky with its sun, or an even one of a radiance."),
    click.option("--env", type=FILE, metavar="FILE.hdr|exr", help="Surroundings from a picture."),
    click.option("--point", type=Numbers(6, "X,Y,Z,R,G,B"), multiple=True, help="Add a point light [m, W/sr]; repeatable."),
    click.option("--spot", type=SpotLight(), multiple=True, help="Add a spot light: from, to [m], intensity [W/sr], cutoff [deg]; repeatable."),
    click.option("--ceiling", type=Ceiling(), help="Add a ceiling: the height of its lower face [m], or the top of the walls."),
    click.option("--clear", metavar="NAME", multiple=True, help="Light passes what is made of this material, or is called so, as if it were not there; repeatable."),
    click.option("--time", type=Finite(), metavar="SECONDS", help="Show this moment of an animation of the file, not the file at rest."),
    click.option("--clip", metavar="NAME", help="Of which animation, by name or number; the first by default."),
    click.option("--materials", type=click.Choice(["full", "diffuse"]), default="full", show_default=True, help="As the scene has them, or every surface diffuse and no glass."),
)  # fmt: skip
"""Named like the fields of `SceneRequest`."""

SETTINGS_OPTIONS: tuple[Option, ...] = (
    click.option("--preset", default="default", show_default=True, help="Settings to start from: see `ddgi presets`."),
    click.option("--config", type=FILE, metavar="FILE.toml", help="Settings from a file."),
    click.option("--set", multiple=True, metavar="STAGE.FIELD=VALUE", help="One setting; repeatable."),
    click.option("--seed", type=click.IntRange(0, 0xFFFFFFFF), help="Same seed, same machine: same picture."),
    click.option("--backend", type=click.Choice(["auto", "llvm", "cuda"]), default="auto", show_default=True, help="CPU, or NVIDIA GPU."),
    click.option("--debug", is_flag=True, help="Show tracebacks and Mitsuba's own messages."),
)  # fmt: skip
"""Named like the fields of `SettingsRequest`."""

json_option = click.option(
    "--json", "json_file", type=FILE, metavar="FILE", help="Write figures to a file; - prints them."
)


def request_options(command: Command) -> Callable[..., Any]:
    """Give a command both groups of options, and hand it the two requests in their place."""

    def call(**values: Any) -> Any:
        scene = SceneRequest(**{name: values.pop(name) for name in SceneRequest.__dataclass_fields__})
        settings = SettingsRequest(
            **{name: values.pop(name) for name in SettingsRequest.__dataclass_fields__}
        )
        return command(**values, scene_request=scene, settings_request=settings)

    call.__doc__, call.__name__ = command.__doc__, command.__name__
    # What decorators below this one added stays in front.
    call.__click_params__ = getattr(command, "__click_params__", [])  # type: ignore[attr-defined]
    for option in reversed((*SCENE_OPTIONS, *SETTINGS_OPTIONS)):  # the last one applied comes first
        option(call)
    return call
