"""The lights of a scene, as everything that gathers light sees them.

Delta lights (point, spot, directional) are ours, in one table: they are evaluated exactly, one
shadow ray each. Area lights and the environment stay Mitsuba emitters: they are sampled, or left
to the field (`lighting/direct.py`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import drjit as dr
import mitsuba as mi

from ddgi.extrema import at_least, clamp
from ddgi.lighting import environment_map
from ddgi.lighting.environment_map import EnvironmentMap

POINT, SPOT, DIRECTIONAL = 0, 1, 2


@dataclass
class DeltaLights:
    """N point, spot and directional lights, one column each."""

    count: int
    kind: mi.UInt32  # (N,) POINT, SPOT or DIRECTIONAL
    position: mi.Float  # (4 N,) x y z, unused [m]
    direction: mi.Float  # (4 N,) x y z: the way light travels, unit length; unused
    intensity: mi.Float  # (4 N,) r g b, unused; W/sr, or W/m^2 facing a directional light
    cone: mi.Float  # (2 N,) spot: cutoff angle [rad], 1 / (cutoff - beam width)


@dataclass
class Lights:
    """All lights of a scene."""

    delta: DeltaLights
    area: mi.EmitterPtr | None  # (A,) area emitters to sample, None without any
    area_count: int
    area_bounds: mi.Float  # (4 A,) sphere around each: centre x y z, radius [m]
    area_power: mi.Float  # (A,) emitted radiance times area, luminance [W/sr]
    area_share: mi.Float  # (A,) what remains of the emitter's own output, >= 0: 0 off, 1 as it is
    environment: mi.Emitter | None  # constant or envmap, what rays that leave the scene see
    environment_map: EnvironmentMap | None  # what an envmap shows
    environment_share: mi.Float  # (1,) likewise


@dataclass
class LightSample:
    """One direction to a light from each of N points, before visibility."""

    direction: mi.Vector3f  # (N,) unit, towards the light
    distance: mi.Float  # (N,) [m], infinite for lights at infinity
    power: mi.Color3f  # (N,) irradiance facing the light, divided by the sampling density


@dataclass
class DeltaLight:
    """One row of `DeltaLights`; fields as there."""

    kind: mi.UInt32
    position: mi.Vector4f
    direction: mi.Vector4f
    intensity: mi.Vector4f
    cone: mi.Vector2f


def delta_light(lights: DeltaLights, number: mi.UInt32) -> DeltaLight:
    """Row `number` of the table."""
    return DeltaLight(
        dr.gather(mi.UInt32, lights.kind, number),
        dr.gather(mi.Vector4f, lights.position, number),
        dr.gather(mi.Vector4f, lights.direction, number),
        dr.gather(mi.Vector4f, lights.intensity, number),
        dr.gather(mi.Vector2f, lights.cone, number),
    )


def from_delta(light: DeltaLight, position: mi.Point3f) -> LightSample:
    """A point, spot or directional light as seen from points. position: (N,) [m].

    A spot light falls off as Mitsuba's: linearly in the angle, from its beam width to its cutoff.
    """
    distant = light.kind == DIRECTIONAL
    to_light = mi.Point3f(light.position.xyz) - position
    distance2 = at_least(dr.squared_norm(to_light), 1e-12)
    axis = mi.Vector3f(light.direction.xyz)
    direction = dr.select(distant, -axis, to_light * dr.rsqrt(distance2))
    angle = dr.acos(clamp(dr.dot(-direction, axis), -1, 1))
    spot = dr.select(light.kind == SPOT, clamp((light.cone.x - angle) * light.cone.y, 0, 1), 1)
    falloff = dr.select(distant, 1, dr.rcp(distance2)) * spot
    power = mi.Color3f(light.intensity.xyz) * falloff
    return LightSample(direction, dr.select(distant, dr.inf, dr.sqrt(distance2)), power)


def area_light(lights: Lights, number: mi.UInt32, position, sample: mi.Point2f, active) -> LightSample:
    """A point on area emitter `number`, one of `lights.area_count`, picked by two uniform numbers."""
    emitter = dr.gather(mi.EmitterPtr, lights.area, number, active)
    out = _sample_emitter(emitter, position, sample, active)
    return replace(out, power=out.power * dr.gather(mi.Float, lights.area_share, number, active))


def pick_area_light(lights: Lights, position: mi.Point3f, u: mi.Float) -> tuple[mi.UInt32, mi.Float]:
    """Pick the area emitter to sample, those that are bright and near more often.

    A light is picked in proportion to its power over its squared distance: with equal chances,
    the many lamps of a large building would drown a room in the noise of other rooms' lamps.

    Args:
        lights: At least one area emitter.
        position: (N,) points to be lit [m].
        u: (N,) uniform numbers.

    Returns:
        (N,) number of the emitter, and the chance it had.
    """

    def body(number, total, picked, share, u):
        sphere = dr.gather(mi.Vector4f, lights.area_bounds, number)
        distance2 = dr.squared_norm(mi.Point3f(sphere.xyz) - position)
        weight = dr.gather(mi.Float, lights.area_power, number) / at_least(distance2, dr.square(sphere.w))
        total = total + weight
        chance = weight / at_least(total, 1e-30)
        take = u < chance
        # What is left of the random number is uniform again, whichever way it fell.
        u = dr.select(take, u / at_least(chance, 1e-30), (u - chance) / at_least(1 - chance, 1e-30))
        return number + 1, total, dr.select(take, number, picked), dr.select(take, weight, share), u

    width = dr.width(position)
    start = (
        mi.UInt32(0),
        dr.zeros(mi.Float, width),
        dr.zeros(mi.UInt32, width),
        dr.zeros(mi.Float, width),
        u,
    )
    _, total, picked, share, _ = dr.while_loop(
        start, lambda number, *_: number < lights.area_count, body, label="pick an area light"
    )
    return picked, share / at_least(total, 1e-30)


def environment_light(lights: Lights, position, sample: mi.Point2f, active) -> LightSample:
    """A direction to the environment, picked where it is bright."""
    if lights.environment_map is not None:
        direction, density = environment_map.sample(lights.environment_map, sample)
        seen = environment_radiance(lights, direction, active)
        return LightSample(direction, mi.Float(dr.inf), seen * dr.rcp(at_least(density, 1e-30)))
    out = _sample_emitter(lights.environment, position, sample, active)
    return LightSample(out.direction, mi.Float(dr.inf), out.power * lights.environment_share)


def _sample_emitter(emitter, position, sample, active) -> LightSample:
    here = dr.zeros(mi.SurfaceInteraction3f, dr.width(position))
    here.p = position
    found, weight = emitter.sample_direction(here, sample, active)
    usable = active & (found.pdf > 0)
    power = dr.select(usable, mi.Color3f(weight), mi.Color3f(0))
    return LightSample(dr.select(usable, found.d, mi.Vector3f(0, 0, 1)), found.dist, power)


def environment_radiance(lights: Lights, direction: mi.Vector3f, active: mi.Bool) -> mi.Color3f:
    """Radiance of the environment in directions. direction: (N,) unit, away from the viewer."""
    if lights.environment is None:
        return mi.Color3f(0)
    if lights.environment_map is not None:
        seen = environment_map.radiance(lights.environment_map, direction, active)
    else:
        beyond = dr.zeros(mi.SurfaceInteraction3f, dr.width(direction))
        beyond.wi = -direction
        seen = mi.Color3f(lights.environment.eval(beyond, active))
    return dr.select(active, seen * lights.environment_share, mi.Color3f(0))
