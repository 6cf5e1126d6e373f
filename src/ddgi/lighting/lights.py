"""The lights of a scene, as everything that gathers light sees them.

Delta lights (point, spot, directional) are ours, in one table: they are evaluated exactly, one
shadow ray each. Area lights and the environment stay Mitsuba emitters: they are sampled, or left
to the field (`lighting/direct.py`).
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi

from ddgi.extrema import at_least, clamp

POINT, SPOT, DIRECTIONAL = 0, 1, 2


@dataclass
class DeltaLights:
    """N point, spot and directional lights, one column each."""

    count: int
    kind: mi.UInt32          # (N,) POINT, SPOT or DIRECTIONAL
    position: mi.Float       # (4 N,) x y z, unused [m]
    direction: mi.Float      # (4 N,) x y z: the way light travels, unit length; unused
    intensity: mi.Float      # (4 N,) r g b, unused; W/sr, or W/m^2 facing a directional light
    cone: mi.Float           # (2 N,) spot: cutoff angle [rad], 1 / (cutoff - beam width)


@dataclass
class Lights:
    """All lights of a scene."""

    delta: DeltaLights
    area: mi.EmitterPtr | None        # (A,) area emitters to sample, None without any
    area_count: int
    environment: mi.Emitter | None    # constant or envmap, what rays that leave the scene see


@dataclass
class LightSample:
    """One direction to a light from each of N points, before visibility."""

    direction: mi.Vector3f  # (N,) unit, towards the light
    distance: mi.Float      # (N,) [m], infinite for lights at infinity
    power: mi.Color3f       # (N,) irradiance facing the light, divided by the sampling density


def delta_light(lights: DeltaLights, number: mi.UInt32, position: mi.Point3f) -> LightSample:
    """Point, spot or directional light `number`, as seen from points. position: (N,) [m].

    A spot light falls off as Mitsuba's: linearly in the angle, from its beam width to its cutoff.
    """
    kind = dr.gather(mi.UInt32, lights.kind, number)
    place = dr.gather(mi.Vector4f, lights.position, number)
    axis = dr.gather(mi.Vector4f, lights.direction, number)
    light = dr.gather(mi.Vector4f, lights.intensity, number)
    cone = dr.gather(mi.Vector2f, lights.cone, number)
    distant = kind == DIRECTIONAL

    to_light = mi.Point3f(place.x, place.y, place.z) - position
    distance2 = at_least(dr.squared_norm(to_light), 1e-12)
    axis = mi.Vector3f(axis.x, axis.y, axis.z)
    direction = dr.select(distant, -axis, to_light * dr.rsqrt(distance2))
    angle = dr.acos(clamp(dr.dot(-direction, axis), -1, 1))
    spot = dr.select(kind == SPOT, clamp((cone.x - angle) * cone.y, 0, 1), 1)
    falloff = dr.select(distant, 1, dr.rcp(distance2)) * spot
    power = mi.Color3f(light.x, light.y, light.z) * falloff
    return LightSample(direction, dr.select(distant, dr.inf, dr.sqrt(distance2)), power)


def area_light(lights: Lights, number: mi.UInt32, position, sample: mi.Point2f, active) -> LightSample:
    """A point on area emitter `number`, one of `lights.area_count`, picked by two uniform numbers."""
    emitter = dr.gather(mi.EmitterPtr, lights.area, number, active)
    return _sample_emitter(emitter, position, sample, active)


def environment_light(lights: Lights, position, sample: mi.Point2f, active) -> LightSample:
    """A direction to the environment, picked where it is bright."""
    out = _sample_emitter(lights.environment, position, sample, active)
    return LightSample(out.direction, mi.Float(dr.inf), out.power)


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
    beyond = dr.zeros(mi.SurfaceInteraction3f, dr.width(direction))
    beyond.wi = -direction
    return dr.select(active, mi.Color3f(lights.environment.eval(beyond, active)), mi.Color3f(0))
