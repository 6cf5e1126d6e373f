"""What the options ask for, as records: plain values that travel to other processes."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from ddgi.scene.scene import Scene
    from ddgi.settings import RenderSettings

Numbers = tuple[float, ...]


@dataclass(frozen=True, kw_only=True)
class SceneRequest:
    """What the camera sees, and what is added to the scene."""

    size: tuple[int, int] | None = None
    camera: str | None = None
    look: Numbers | None = None  # from, to
    up: str | Numbers | None = None
    near: float | None = None
    sun: tuple[float, float, float] | None = None
    sky: str | Numbers | None = None
    env: Path | None = None
    point: tuple[Numbers, ...] = ()  # position, intensity
    spot: tuple[Numbers, ...] = ()  # position, target, intensity, cutoff angle
    ceiling: float | Literal["auto"] | None = None
    clear: tuple[str, ...] = ()
    materials: str = "full"
    time: float | None = None  # [s]
    clip: str | None = None

    def open(self, source: str) -> Scene:
        """Load a scene as asked for."""
        from dataclasses import replace

        from ddgi.scene.camera import with_near
        from ddgi.scene.load import load_scene

        scene = load_scene(
            source,
            camera=self.camera,
            look=self.look,
            size=self.size,
            up=self.up,
            sun=self.sun,
            sky=self.sky,
            env=self.env,
            lights=[*map(_point_light, self.point), *map(_spot_light, self.spot)],
            ceiling=self.ceiling,
            clear=self.clear,
            materials=self.materials,
        )
        if self.time is not None or self.clip is not None:
            scene = scene.at(self.time or 0.0, self.clip)
        if self.near is not None:
            scene = replace(scene, cameras=tuple(with_near(c, self.near) for c in scene.cameras))
        return scene

    def arguments(self) -> list[str]:
        """As the command line has it."""
        return _arguments(self)


@dataclass(frozen=True, kw_only=True)
class SettingsRequest:
    """What shapes a frame, and what computes."""

    preset: str = "default"
    config: Path | None = None
    set: tuple[str, ...] = ()
    seed: int | None = None
    backend: str = "auto"
    debug: bool = False

    def settings(self) -> RenderSettings:
        """All sources together, checked."""
        from ddgi.config import load_settings

        seed = () if self.seed is None else (f"seed={self.seed}",)
        return load_settings(self.preset, self.config, (*self.set, *seed))

    def start_backend(self) -> str:
        """Choose the backend, and quieten Mitsuba: what matters comes as our own errors and notes."""
        from ddgi.backend import use_backend

        chosen = use_backend(self.backend)
        if not self.debug:
            import mitsuba as mi

            mi.set_log_level(mi.LogLevel.Error)
        return chosen

    def arguments(self) -> list[str]:
        """As the command line has it."""
        return _arguments(self)


def _point_light(numbers: Numbers) -> dict[str, Any]:
    return {"type": "point", "position": list(numbers[:3]), "intensity": _rgb(numbers[3:])}


def _spot_light(numbers: Numbers) -> dict[str, Any]:
    import mitsuba as mi

    origin, target = numbers[:3], numbers[3:6]
    along = [abs(t - o) for o, t in zip(origin, target, strict=True)]
    up = [float(axis == along.index(min(along))) for axis in range(3)]  # the axis least along the view
    place = mi.ScalarTransform4d().look_at(origin=list(origin), target=list(target), up=up)
    return {"type": "spot", "to_world": place, "intensity": _rgb(numbers[6:9]), "cutoff_angle": numbers[9]}


def _rgb(values: Numbers) -> dict[str, Any]:
    return {"type": "rgb", "value": list(values)}


def _arguments(request: SceneRequest | SettingsRequest) -> list[str]:
    """Options whose names are the fields'; those left at their defaults are left out."""
    out = []
    for field in fields(request):
        value = getattr(request, field.name)
        if value == field.default:
            continue
        if value is True:
            out.append(f"--{field.name}")
            continue
        several = isinstance(value, tuple) and field.default == ()
        for one in value if several else (value,):
            out.append(f"--{field.name}={_text(one, 'x' if field.name == 'size' else ',')}")
    return out


def _text(value: Any, separator: str) -> str:
    return separator.join(map(repr, value)) if isinstance(value, tuple) else str(value)
