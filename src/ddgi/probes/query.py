"""The query: irradiance at any point, for any orientation, from the eight probes around it.

Each probe of the cell counts by a product of weights: trilinear, how far it lies in front of the
surface, how likely it sees the point (Chebyshev on its distance map), and a crush of what little
is left. Each can be switched off by itself (CTU Fig. 7.1 adds them one by one).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import Annotated, Literal, TypeAlias

import drjit as dr
import mitsuba as mi
from annotated_types import Ge, Interval
from typing_extensions import Doc

from ddgi.extrema import at_least, at_most, clamp
from ddgi.probes import formats, sight, trilinear, volume
from ddgi.probes.awake import States
from ddgi.probes.grid import ProbeGrid
from ddgi.probes.octahedral import direction_to_square, texel_at
from ddgi.probes.volume import ProbeVolume
from ddgi.settings_group import settings_group
from ddgi.trace.surface import Surface
from ddgi.trace.tracer import Tracer


@settings_group("query")
class Settings:
    """How the eight probes of a cell are weighted."""

    trilinear: Annotated[bool, Doc("weight probes by their place in the cell")] = True
    follow_moved: Annotated[
        bool, Doc("trilinear weights go by where moved probes stand, and not by their places (MFF 3.3.1)")
    ] = False
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
    sight: Annotated[
        Literal["maps", "cells", "rays"],
        Doc(
            "what tells whether probes see the point: their distance maps; rays between the probes of a cell, too; and, "
            "where something is in the way of those, rays from the point"
        ),
    ] = "rays"
    sqrt_blending: Annotated[
        bool, Doc("average probes in square-root space (SCALE listing 2); loses light to noise")
    ] = False


SMALLEST = 1e-6
"""Least weight of a probe before the trilinear one, so that eight hidden probes still average."""


def lookup_exponent(s: Settings) -> float:
    """Maps hold S to this power, so that the query decodes once and not per tap."""
    return 0.5 if s.sqrt_blending else 1.0


@dataclass
class Receiver:
    """N points of surfaces that ask for light."""

    position: mi.Point3f  # (N,) [m]; outside the volume its nearest cell is read
    normal: mi.Vector3f  # (N,) unit
    to_viewer: mi.Vector3f  # (N,) unit, towards where the point is seen from (SCALE eq. 2)
    active: mi.Bool  # (N,) other lanes get zero
    start: mi.Point3f  # (N,) where rays start that leave the surface [m]
    # Length of the ray that found the point, (N,) [m]. The self-shadow bias moves the point towards the viewer; that far
    # the way is free, beyond it may lead through a wall. None: not known.
    view_distance: mi.Float | None = None

    @staticmethod
    def on(surface: Surface) -> Receiver:
        """The points of surfaces that can reflect light."""
        start = dr.fma(mi.Vector3f(surface.geometric_normal), surface.slack, surface.position)
        normal = mi.Vector3f(surface.normal)
        return Receiver(surface.position, normal, surface.to_viewer, surface.lit, start, surface.distance)


def irradiance(
    vol: ProbeVolume,
    at: Receiver,
    layout: volume.Settings,
    s: Settings,
    tracer: Tracer | None = None,
    tap: mi.Point2f | None = None,
) -> mi.Color3f:
    """Irradiance E [W/m^2] that arrives at oriented points, from one volume.

    Args:
        vol: The volume.
        at: The points.
        layout: What the probes store.
        s: The weights.
        tracer: Asked where probes may be hidden, for a `sight` of "rays"; None: nothing is asked.
        tap: (N,) uniform numbers. With them each map read takes one texel, picked with the
            bilinear weights, in place of four: right on average, four times fewer reads.

    Returns:
        (N,) irradiance; a field of constant radiance L gives pi L.
    """
    return irradiance_by(vol, at, shares(vol, at, layout, s, tracer, tap), layout, s, tap)


Shares: TypeAlias = "list[tuple[mi.UInt32, mi.Float]]"
"""The eight probes around N points, (number, share) each; the shares add up to one. (N,)."""


def irradiance_by(
    vol: ProbeVolume,
    at: Receiver,
    probes: Shares,
    layout: volume.Settings,
    s: Settings,
    tap: mi.Point2f | None = None,
) -> mi.Color3f:
    """Irradiance E [W/m^2] of points whose probes are known, (N,): `irradiance` by their `shares`."""
    towards = texel_at(direction_to_square(at.normal), layout.irradiance_size, tap)
    fmt = formats.IRRADIANCE[layout.irradiance_format]
    mean = mi.Color3f(0)
    for probe, share in probes:
        mean += share * _interpolate(fmt, vol.irradiance, layout.irradiance_size, probe, towards, at.active)
    return dr.pi * (dr.square(mean) if s.sqrt_blending else mean)


def alone(
    vol: ProbeVolume, at: Receiver, probes: Shares, layout: volume.Settings, s: Settings
) -> list[mi.Color3f]:
    """Irradiance E [W/m^2] that points would have from each of their probes alone. 8 x (N,)."""
    return [irradiance_by(vol, at, [(probe, mi.Float(1))], layout, s) for probe, _ in probes]


def radiance_by(
    vol: ProbeVolume,
    at: Receiver,
    probes: Shares,
    direction: mi.Vector3f,
    layout: volume.Settings,
    tap: mi.Point2f | None = None,
) -> mi.Color3f:
    """Radiance [W/(m^2 sr)] that the probes of points saw in some direction. (N,).

    `direction`, (N,) unit, leads away from the point; `probes` are its `shares`, other arguments as of `irradiance`.
    Reads the maps of radiance: `layout.radiance_size` is not 0.
    """
    towards = texel_at(direction_to_square(direction), layout.radiance_size, tap)
    fmt = formats.IRRADIANCE[layout.irradiance_format]
    mean = mi.Color3f(0)
    for probe, share in probes:
        mean += share * _interpolate(fmt, vol.radiance, layout.radiance_size, probe, towards, at.active)
    return mean


def shares(
    vol: ProbeVolume,
    at: Receiver,
    layout: volume.Settings,
    s: Settings,
    tracer: Tracer | None = None,
    tap: mi.Point2f | None = None,
) -> Shares:
    """Which probes light points, and by how much. Arguments as of `irradiance`."""
    first, weights, total = weighed(vol, at, layout, s, tracer, tap)
    if _judges_sight(vol, s):
        # Nothing here sees the point: it is lit like the air in front of it, which its viewer sees through.
        ahead = _ahead(vol, at)

        def elsewhere(at, tap):
            return weighed(vol, at, layout, s, tracer, tap, in_air=True)[:2]

        first, weights = dr.if_stmt(
            (ahead, tap), (total < sight.LOST) & at.active, elsewhere, lambda *_: (first, weights)
        )
    numbers = [first + vol.grid.number(k & 1, k >> 1 & 1, k >> 2 & 1) for k in range(8)]
    total = sum(weights)
    if vol.states is not None:
        none = (total <= 0) & at.active
        numbers, weights = dr.if_stmt(
            (at.position, numbers, weights),
            none,
            partial(_stood_in, vol.grid, vol.states),
            lambda _, numbers, weights: (numbers, weights),
        )
        total = dr.select(none, sum(weights), total)
    scale = dr.rcp(at_least(total, 1e-20))
    return [(number, weight * scale) for number, weight in zip(numbers, weights, strict=True)]


def _stood_in(grid: ProbeGrid, states: States, position: mi.Point3f, *_):
    """Probes and weights of points that no probe counts for: if none of theirs gives light, the nearest that do stand in.

    If some do, and are hidden, it is dark there.
    """
    base, place = _cell(grid, position)
    first = grid.number(*(mi.UInt32(base[i]) for i in range(3)))
    own = [first + grid.number(k & 1, k >> 1 & 1, k >> 2 & 1) for k in range(8)]
    stand_ins = [dr.gather(mi.UInt32, states.stand_in, number) for number in own]
    idle = mi.Bool(True)
    for number, stand_in in zip(own, stand_ins, strict=True):
        idle &= stand_in != number
    return stand_ins, [dr.select(idle, near, 0) for near in trilinear.regular(place)]


def _judges_sight(vol: ProbeVolume, s: Settings) -> bool:
    return s.sight != "maps" and vol.sight is not None


def _ahead(vol: ProbeVolume, at: Receiver) -> Receiver:
    """The points moved towards their viewer by a spacing, or as far as it stands."""
    length = vol.grid.smallest_spacing
    if at.view_distance is not None:
        length = at_most(length, at.view_distance)
    position = dr.fma(at.to_viewer, length, at.position)
    return replace(at, position=position, start=position, view_distance=None)


def weighed(vol, at: Receiver, layout, s: Settings, tracer, tap, *, in_air: bool = False):
    """First probe of the cells that points lie in, weights of their eight probes, and what those in front weigh.

    Where the last is below `sight.LOST` none of them sees the point, and `shares` reads another cell. Arguments as
    of `irradiance`; in_air: there is no surface that probes could be behind.
    """
    found = factors(vol, at, layout, s, tap, in_air=in_air)
    each = list(zip(found.near, found.wrap, found.visible, strict=True))
    weights = [crushed(wrap * visible, s) * near for near, wrap, visible in each]
    if not _judges_sight(vol, s):
        return found.first, weights, sum(weights)
    unhidden = [crushed(wrap, s) * near for near, wrap, _ in each]
    seen = dr.gather(mi.UInt32, vol.sight, sight.cell_number(vol.grid, found.base), at.active)
    facing = [mi.Bool(True) if in_air else dr.dot(way, at.normal) > 0 for way in found.ways]
    asks = None
    if s.sight == "rays" and tracer is not None:
        # Towards the viewer the way is free.
        air = None if in_air else dr.fma(at.to_viewer, found.ahead, at.start)
        to_first = found.corner + (at.position - at.start)
        asks = sight.Asks(tracer, at.start, air, vol.grid, found.first, to_first, at.active)
    weights, front = sight.believed(seen, weights, unhidden, facing, asks, everywhere=in_air)
    return found.first, weights, front


@dataclass
class Factors:
    """What the eight probes of the cells of N points count for, factor by factor, before sight; lists hold 8 x (N,)."""

    first: mi.UInt32  # (N,) number of the cell's first probe
    base: mi.Vector3f  # (N,) its coordinates
    corner: mi.Vector3f  # (N,) from the point to its place [m]
    ahead: mi.Float  # how far the point is moved towards its viewer for visibility [m]
    ways: list[mi.Vector3f]  # from the point to each probe [m]
    near: list[mi.Float]  # trilinear weights; 0 of those that give no light
    wrap: list[mi.Float]  # for the angle to the surface
    visible: list[mi.Float]  # what their distance maps say


def factors(
    vol: ProbeVolume,
    at: Receiver,
    layout: volume.Settings,
    s: Settings,
    tap: mi.Point2f | None = None,
    *,
    in_air: bool = False,
) -> Factors:
    """The weights of probes, part by part. Arguments as of `irradiance`; in_air: there is no surface, and no bias."""
    grid = vol.grid
    base, place = _cell(grid, at.position)
    corner = dr.fma(base, grid.spacing, grid.origin) - at.position
    off, ahead = (mi.Float(0), mi.Float(0)) if in_air else _bias(grid, at, s)
    shift = at.normal * off + at.to_viewer * ahead
    first = grid.number(*(mi.UInt32(base[i]) for i in range(3)))
    unit = dr.rcp(vol.reach(layout))
    around = grid.around(first, at.active)
    moved = None if around is None else [mi.Vector3f(a.xyz) for a in around]
    ways = _ways(grid, corner, moved)
    visible = [mi.Float(1)] * 8
    if s.visibility and not in_air:  # there, rays are asked about all
        for k, way in enumerate(ways):
            probe = first + grid.number(k & 1, k >> 1 & 1, k >> 2 & 1)
            visible[k] = _visibility(vol, probe, shift - way, unit, at.active, layout, s, tap)
    wrap = [_wrap(way, at.normal, s) for way in ways]
    near = _near(grid, place, moved, s)
    if around is not None:
        near = [n * a.w for n, a in zip(near, around, strict=True)]
    return Factors(first, base, corner, ahead, ways, near, wrap, visible)


def _ways(grid, corner, moved) -> list[mi.Vector3f]:
    """From points to the eight probes of their cells [m]. 8 x (N,).

    Args:
        grid: Of the probes.
        corner: (N,) from the points to the cell's first place [m].
        moved: 8 x (N,) from the places to where the probes stand [m]; None: they stand there.
    """
    # They share their coordinates along each axis in fours: two values an axis.
    sides = [(corner[i], corner[i] + grid.spacing[i]) for i in range(3)]
    ways = [mi.Vector3f([sides[i][k >> i & 1] for i in range(3)]) for k in range(8)]
    return ways if moved is None else [way + m for way, m in zip(ways, moved, strict=True)]


def _near(grid, place, moved, s: Settings) -> list[mi.Float]:
    """What the eight probes count for the place of points in the cell. 8 x (N,); `moved` as of `_ways`."""
    if not s.trilinear:
        return [mi.Float(1)] * 8
    if moved is None or not s.follow_moved:
        return trilinear.regular(place)
    scale = dr.rcp(grid.spacing)
    return trilinear.corrected(place, [m * scale for m in moved])


def crushed(weight: mi.Float, s: Settings) -> mi.Float:
    """What is left of a probe's weight, before the trilinear one (CTU eq. 4.10)."""
    weight = at_least(weight, SMALLEST)
    return weight * at_most(dr.square(weight / s.crush), 1) if s.crush > 0 else weight


def _cell(grid, position):
    """Coordinates of the cell's first probe, and the place within the cell in [0, 1]^3."""
    place = mi.Vector3f((position - grid.origin) / grid.spacing)
    last = mi.Vector3f([float(n - 2) for n in grid.counts])
    base = clamp(dr.floor(place), 0, last)
    return base, clamp(place - base, 0, 1)


def _bias(grid, at: Receiver, s: Settings) -> tuple[mi.Float, mi.Float]:
    """How far the point is moved along its normal and towards its viewer before its visibility is tested [m]."""
    match s.bias:
        case "scale":
            unit = grid.smallest_spacing * (0.75 * s.bias_scale)
            along_normal, along_view = 0.2 * unit, 0.8 * unit
        case "ctu":
            along_normal, along_view = mi.Float(0.8 * s.bias_scale), mi.Float(0.3 * s.bias_scale)
        case "mff":
            along_normal, along_view = mi.Float(s.bias_scale), mi.Float(3 * s.bias_scale)
        case _:
            return mi.Float(0), mi.Float(0)
    if at.view_distance is not None:
        along_view = at_most(along_view, at.view_distance)
    return along_normal, along_view


def _wrap(to_probe, normal, s: Settings) -> mi.Float:
    """How much a probe counts for its angle to the surface."""
    if s.wrap == "off":
        return mi.Float(1)
    length2 = at_least(dr.squared_norm(to_probe), 1e-20)
    cosine = dr.dot(to_probe, normal) * dr.rsqrt(length2)
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
