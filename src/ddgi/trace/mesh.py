"""Tracing the triangles and analytic shapes of a Mitsuba scene."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi

from ddgi.sampling import Clock, uniform_2d
from ddgi.trace.materials import Materials, lookup, lookup_normal, lookup_opacity
from ddgi.trace.movers import Movers
from ddgi.trace.surface import Surface, slack
from ddgi.trace.vertex_colors import Corner

MAX_LAYERS = 32
"""Surfaces with opacity below one that a ray passes before it stops looking."""


@dataclass
class _Hit:
    """Where rays met something."""

    si: mi.SurfaceInteraction3f
    row: mi.UInt32  # of the material table: the registry number of the shape that was hit
    corner: Corner | None  # where on its triangle, if vertices have colours


@dataclass
class MeshTracer:
    """A `Tracer` over `mi.Scene` (Embree on the CPU, OptiX on the GPU)."""

    scene: mi.Scene  # what stays where it is
    materials: Materials
    origin: mi.Point3d  # (1,) see `Tracer`
    extent: mi.Float  # (1,) the largest coordinate in the scene [m]
    serial: int = 0  # of the scene that was loaded: recordings are good for one (`ddgi.replay`)
    movers: Movers | None = None  # what does not

    @property
    def shining(self) -> bool:
        """See `Tracer.shining`."""
        return self.materials.any_specular

    def intersect(
        self, origin, direction, active, *, time: Clock, stream: int, coherent: bool = False, reach=None,
        bumps: bool = False,
    ):  # fmt: skip
        """See `Tracer.intersect`."""
        skipped = mi.Float(0)
        if self.materials.any_opacity:
            skipped = self._pass_through(origin, direction, active, time, stream)
        ray = mi.Ray3f(dr.fma(direction, skipped, origin), direction)
        if reach is not None:
            ray.maxt = reach - skipped
        flags = mi.RayFlags.ShadingFrame
        if self.materials.textures is not None:
            flags = flags | mi.RayFlags.UV
        bumps = bumps and self.materials.any_normal_texture
        if bumps:
            flags = flags | mi.RayFlags.dPdUV
        hit = self._hit(ray, flags, coherent, active)
        return self._surface(hit, direction, skipped, bumps)

    def visible(self, origin, direction, distance, active):
        """See `Tracer.visible`."""
        if not self.materials.any_opacity:
            ray = mi.Ray3f(origin, direction, distance, 0.0, [])
            hidden = self.scene.ray_test(ray, active)
            if self.movers is not None:
                hidden = hidden | self.movers.scene.ray_test(ray, active & ~hidden)
            return dr.select(active & ~hidden, mi.Float(1), mi.Float(0))
        return self._transmittance(origin, direction, distance, active)

    def _hit(self, ray, flags, coherent, active) -> _Hit:
        """What a ray meets."""
        found = self.scene.ray_intersect_preliminary(ray, coherent, active)
        if self.movers is not None:
            found = self.movers.nearest(ray, found, coherent, active)
        si = found.compute_surface_interaction(ray, int(flags), active)
        row, face = dr.reinterpret_array(mi.UInt32, si.shape), found.prim_index
        if self.movers is not None:
            row, face = self.movers.of(row, face, active & si.is_valid())
        corner = None if self.materials.vertex_colors is None else Corner(face, found.prim_uv)
        return _Hit(si, row, corner)

    def _surface(self, hit: _Hit, direction, skipped, bumps: bool) -> Surface:
        si, row, corner = hit.si, hit.row, hit.corner
        valid = si.is_valid()
        material = lookup(self.materials, row, si.uv, valid, corner)
        position = dr.select(valid, si.p, mi.Point3f(0))
        up = mi.Normal3f(0, 0, 1)
        # Vertex normals, where a mesh has them, say which side is its front; the winding need not agree.
        shading = si.sh_frame.n
        outward = dr.mulsign(si.n, dr.dot(si.n, shading))
        front = dr.dot(outward, direction) < 0
        flip = dr.select(front, mi.Float(1), mi.Float(-1))
        back = mi.Bool(False)
        if self.materials.any_single_sided:
            back = valid & ~front & ~material.double_sided
        normal = shading * flip
        if bumps:
            n = lookup_normal(self.materials, row, si.uv, valid)
            normal = n.x * si.sh_frame.s + n.y * si.sh_frame.t + n.z * normal
        return Surface(
            valid=valid,
            front=valid & front,
            back=back,
            distance=si.t + skipped,
            position=position,
            slack=slack(position, self.extent),
            normal=dr.select(valid, mi.Normal3f(normal), up),
            geometric_normal=dr.select(valid, mi.Normal3f(outward * flip), up),
            to_viewer=-direction,
            base=material.base,
            metallic=material.metallic,
            alpha=material.alpha,
            specular=material.specular,
            disney=material.disney,
            emission=dr.select(front, material.emission, mi.Color3f(0)),
        )

    def _hit_opacity(self, origin, direction, distance, active):
        """Next hit from `origin`: (hit, its distance, its opacity)."""
        ray = mi.Ray3f(origin, direction, distance, 0.0, [])
        found = self._hit(ray, mi.RayFlags.UV, False, active)
        si = found.si
        hit = active & si.is_valid()
        opacity = lookup_opacity(self.materials, found.row, si.uv, hit, found.corner)
        step = si.t + slack(si.p, self.extent)
        return hit, step, opacity

    def _pass_through(self, origin, direction, active, time, stream):
        """Distance to skip: past every layer that a random number finds open.

        Each layer is met with a probability equal to its opacity, so the mean over frames is
        right for any opacity, and cut-outs (0 or 1) are exact at once.
        """
        lane = dr.arange(mi.UInt32, dr.width(direction))

        def body(skipped, searching, layer):
            hit, step, opacity = self._hit_opacity(
                dr.fma(direction, skipped, origin), direction, mi.Float(dr.inf), searching
            )
            chance = uniform_2d(time, stream, lane * MAX_LAYERS + layer).x
            through = hit & (chance >= opacity)
            return skipped + dr.select(through, step, 0), through & (layer + 1 < MAX_LAYERS), layer + 1

        skipped, _, _ = dr.while_loop(
            state=(mi.Float(0) + dr.zeros(mi.Float, dr.width(direction)), mi.Bool(active), mi.UInt32(0)),
            cond=lambda skipped, searching, layer: searching,
            body=body,
            label="pass through masks",
        )
        return skipped

    def _transmittance(self, origin, direction, distance, active):
        """Product of (1 - opacity) over the layers of each segment."""

        def body(share, skipped, searching, layer):
            hit, step, opacity = self._hit_opacity(
                dr.fma(direction, skipped, origin), direction, distance - skipped, searching
            )
            share = dr.select(hit, share * (1 - opacity), share)
            skipped = skipped + dr.select(hit, step, 0)
            return (
                share,
                skipped,
                hit & (share > 0) & (skipped < distance) & (layer + 1 < MAX_LAYERS),
                layer + 1,
            )

        width = dr.width(direction)
        share, *_ = dr.while_loop(
            state=(dr.full(mi.Float, 1, width), dr.zeros(mi.Float, width), mi.Bool(active), mi.UInt32(0)),
            cond=lambda share, skipped, searching, layer: searching,
            body=body,
            label="transmittance",
        )
        return dr.select(active, share, 0)
