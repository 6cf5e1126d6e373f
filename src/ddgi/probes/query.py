"""The query: irradiance at any point, for any orientation, from the eight probes around it.

Each probe of the cell counts by a product of weights: trilinear, how far it lies in front of the
surface, how likely it sees the point (Chebyshev on its distance map), and a crush of what little
is left. Each can be switched off by itself (CTU Fig. 7.1 adds them one by one).
"""

from __future__ import annotations

from typing import Annotated, Literal

import drjit as dr
import mitsuba as mi
from annotated_types import Ge, Interval
from typing_extensions import Doc

from ddgi.extrema import at_least, at_most, clamp
from ddgi.probes import formats, volume
from ddgi.probes.octahedral import direction_to_square, texel_at
from ddgi.probes.volume import ProbeVolume
from ddgi.settings_group import settings_group


@settings_group("query")
class Settings:
    """How the eight probes of a cell are weighted."""

    trilinear: Annotated[bool, Doc("weight probes by their place in the cell")] = True
    wrap: Annotated[
        Literal["half_cosine", "wrap", "sharp", "off"],
        Doc(
            "how probes behind the surface count: ((cos + 1)/2)^2 (2019 paper, MFF eq. 3.3); "
            "((cos + a)/(1 + a))^(1 + a) (CTU eq. 4.4); max(cos, 0) (MFF eq. 3.1); or not at all"
        ),
    ] = "half_cosine"
    wrap_offset: Annotated[
        float, Interval(ge=0, le=1), Doc("added to half_cosine: 0.2 in the 2019 paper, 0 in MFF")
    ] = 0.0
    wrap_a: Annotated[float, Interval(ge=0, le=1), Doc("a of wrap (CTU eq. 4.4)")] = 1.0
    visibility: Annotated[bool, Doc("weight probes by how likely they see the point")] = True
    chebyshev_exponent: Annotated[
        float,
        Interval(ge=0.25, le=16),
        Doc("power of the Chebyshev bound: 3 (MFF listing 3.10), 1 (CTU eq. 4.9)"),
    ] = 3.0
    visibility_floor: Annotated[float, Interval(ge=0, le=1), Doc("least visibility weight of a probe")] = 0.0
    crush: Annotated[
        float, Interval(ge=0, le=1), Doc("weights w below c become w^3/c^2 (CTU eq. 4.10); 0 switches off")
    ] = 0.2
    bias: Annotated[
        Literal["scale", "ctu", "mff", "off"],
        Doc(
            "direction in which the point is moved for visibility: (0.2 n + 0.8 v) 0.75 spacing (SCALE eq. 2); "
            "(0.8 n + 0.3 v) (CTU eq. 4.11); (n + 3 v) (MFF listing 3.9)"
        ),
    ] = "scale"
    bias_scale: Annotated[
        float, Ge(0), Doc("multiplies the bias: 0.3 (SCALE); metres for ctu and mff (0.25 in MFF)")
    ] = 0.6
    sqrt_blending: Annotated[
        bool, Doc("average probes in square-root space (SCALE listing 2); loses light to noise")
    ] = False


SMALLEST = 1e-6
"""Least weight of a probe before the trilinear one, so that eight hidden probes still average."""


def lookup_exponent(s: Settings) -> float:
    """Maps hold S to this power, so that the query decodes once and not per tap."""
    return 0.5 if s.sqrt_blending else 1.0


def irradiance(
    vol: ProbeVolume,
    position: mi.Point3f,
    normal: mi.Vector3f,
    to_viewer: mi.Vector3f,
    active: mi.Bool,
    layout: volume.Settings,
    s: Settings,
    tap: mi.Point2f | None = None,
    view_distance: mi.Float | None = None,
) -> mi.Color3f:
    """Irradiance E [W/m^2] that arrives at oriented points, from one volume.

    Args:
        vol: The volume; points outside read its nearest cell.
        position: (N,) [m].
        normal: (N,) unit.
        to_viewer: (N,) unit, towards where the point is seen from (SCALE eq. 2).
        active: (N,) other lanes return zero.
        layout: What the probes store.
        s: The weights.
        tap: (N,) uniform numbers. With them each map read takes one texel, picked with the
            bilinear weights, in place of four: right on average, four times fewer reads.
        view_distance: (N,) length of the ray that found the point [m]. The self-shadow bias moves the
            point towards the viewer; that far the way is free, beyond it may lead through a wall.

    Returns:
        (N,) irradiance; a field of constant radiance L gives pi L.
    """
    at = texel_at(direction_to_square(normal), layout.irradiance_size, tap)
    fmt = formats.IRRADIANCE[layout.irradiance_format]
    mean = mi.Color3f(0)
    for probe, share in _shares(vol, position, normal, to_viewer, active, layout, s, tap, view_distance):
        mean += share * _interpolate(fmt, vol.irradiance, layout.irradiance_size, probe, at, active)
    return dr.pi * (dr.square(mean) if s.sqrt_blending else mean)


def radiance(
    vol: ProbeVolume,
    position: mi.Point3f,
    normal: mi.Vector3f,
    to_viewer: mi.Vector3f,
    direction: mi.Vector3f,
    active: mi.Bool,
    layout: volume.Settings,
    s: Settings,
    tap: mi.Point2f | None = None,
    view_distance: mi.Float | None = None,
) -> mi.Color3f:
    """Radiance [W/(m^2 sr)] that the probes around oriented points saw in some direction. (N,).

    `direction`, (N,) unit, leads away from the point; other arguments as of `irradiance`, for which
    the probes count likewise. Reads the maps of radiance: `layout.radiance_size` is not 0.
    """
    at = texel_at(direction_to_square(direction), layout.radiance_size, tap)
    fmt = formats.IRRADIANCE[layout.irradiance_format]
    mean = mi.Color3f(0)
    for probe, share in _shares(vol, position, normal, to_viewer, active, layout, s, tap, view_distance):
        mean += share * _interpolate(fmt, vol.radiance, layout.radiance_size, probe, at, active)
    return mean


def _shares(vol, position, normal, to_viewer, active, layout, s: Settings, tap, view_distance):
    """The eight probes around points, (number, share) each; the shares add up to one."""
    grid = vol.grid
    base, place = _cell(grid, position)
    corner = dr.fma(base, grid.spacing, grid.origin) - position  # from the point to the cell's first probe
    shift = _bias(grid, normal, to_viewer, view_distance, s)
    first = grid.number(*(mi.UInt32(base[i]) for i in range(3)))
    unit = dr.rcp(vol.reach(layout))
    # The eight probes share their coordinates along each axis in fours: two values an axis.
    sides = [(corner[i], corner[i] + grid.spacing[i]) for i in range(3)]
    parts = [(1 - place[i], place[i]) for i in range(3)]
    found, total = [], mi.Float(0)
    for k in range(8):
        step = [k & 1, k >> 1 & 1, k >> 2 & 1]
        to_probe = mi.Vector3f([sides[i][step[i]] for i in range(3)])
        probe = first + grid.number(*step)
        weight = _wrap(to_probe, normal, s)
        if s.visibility:
            weight *= _visibility(vol, probe, shift - to_probe, unit, active, layout, s, tap)
        weight = at_least(weight, SMALLEST)
        if s.crush > 0:
            weight *= at_most(dr.square(weight / s.crush), 1)
        if s.trilinear:
            weight *= parts[0][step[0]] * parts[1][step[1]] * parts[2][step[2]]
        found.append((probe, weight))
        total += weight
    scale = dr.rcp(at_least(total, 1e-20))
    return [(probe, weight * scale) for probe, weight in found]


def _cell(grid, position):
    """Coordinates of the cell's first probe, and the place within the cell in [0, 1]^3."""
    place = mi.Vector3f((position - grid.origin) / grid.spacing)
    last = mi.Vector3f([float(n - 2) for n in grid.counts])
    base = clamp(dr.floor(place), 0, last)
    return base, clamp(place - base, 0, 1)


def _bias(grid, normal, to_viewer, view_distance, s: Settings) -> mi.Vector3f:
    """How far the point is moved before its visibility is tested [m]."""
    match s.bias:
        case "scale":
            unit = grid.smallest_spacing * (0.75 * s.bias_scale)
            along_normal, along_view = 0.2 * unit, 0.8 * unit
        case "ctu":
            along_normal, along_view = mi.Float(0.8 * s.bias_scale), mi.Float(0.3 * s.bias_scale)
        case "mff":
            along_normal, along_view = mi.Float(s.bias_scale), mi.Float(3 * s.bias_scale)
        case _:
            return mi.Vector3f(0)
    if view_distance is not None:
        along_view = at_most(along_view, view_distance)
    return mi.Vector3f(normal) * along_normal + to_viewer * along_view


def _wrap(to_probe, normal, s: Settings) -> mi.Float:
    """How much a probe counts for its angle to the surface."""
    if s.wrap == "off":
        return mi.Float(1)
    length2 = at_least(dr.squared_norm(to_probe), 1e-20)
    cosine = dr.dot(to_probe, mi.Vector3f(normal)) * dr.rsqrt(length2)
    match s.wrap:
        case "half_cosine":
            return dr.square(cosine * 0.5 + 0.5) + s.wrap_offset
        case "wrap":
            bent = at_least((cosine + s.wrap_a) / (1 + s.wrap_a), 1e-6)
            return dr.square(bent) if s.wrap_a == 1 else dr.power(bent, 1 + s.wrap_a)
    return at_least(cosine, 0)


def _visibility(vol, probe, from_probe, unit, active, layout, s: Settings, tap) -> mi.Float:
    """One-sided Chebyshev bound on the chance that the probe sees the point (CTU eq. 4.5 to 4.9)."""
    length2 = at_least(dr.squared_norm(from_probe), 1e-20)
    r = dr.sqrt(length2) * unit
    at = texel_at(direction_to_square(from_probe), layout.distance_size, tap)
    moments = _interpolate(
        formats.DISTANCE[layout.distance_format], vol.distance, layout.distance_size, probe, at, active
    )
    beyond = r - moments.x
    variance = dr.abs(moments.y - dr.square(moments.x))
    bound = variance / at_least(variance + dr.square(beyond), 1e-20)
    if s.chebyshev_exponent == 3:
        bound = bound * bound * bound
    elif s.chebyshev_exponent != 1:
        bound = dr.power(bound, s.chebyshev_exponent)
    return dr.select(beyond > 0, at_least(bound, s.visibility_floor), mi.Float(1))


def _interpolate(fmt: formats.Format, store, size: int, probe, at, active):
    """Read a probe's map: bilinear, or the one texel that was picked."""
    texel, fraction = at
    first = probe * (size + 2) ** 2 + texel
    read = lambda offset: formats.read(fmt, store, first + offset, active)  # noqa: E731
    if fraction is None:
        return read(0)
    x, y = fraction
    return dr.lerp(dr.lerp(read(0), read(1), x), dr.lerp(read(size + 2), read(size + 3), x), y)
