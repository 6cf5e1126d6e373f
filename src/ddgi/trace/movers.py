"""What moves in a scene, traced apart from what stays: only it is built anew when it moves.

Everything that moves is one mesh, so that a hundred objects cost one upload and one build. Lamps, and
shapes that are no plain meshes, lie beside it as themselves.
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi


@dataclass
class Movers:
    """The moving part of a scene. F triangles in the common mesh."""

    scene: mi.Scene
    mesh: mi.UInt32  # (1,) registry number of the common mesh; 0 if there is none
    row: mi.UInt32  # (F,) row of the material table of each of its triangles
    face: mi.UInt32  # (F,) number of each triangle in the shape it belongs to

    def nearest(self, ray: mi.Ray3f, found, coherent: bool, active: mi.Bool):
        """What is nearer: what a ray met in the rest of the scene, or what it meets here."""
        ray = mi.Ray3f(ray)
        ray.maxt = dr.select(found.is_valid(), found.t, ray.maxt)
        here = self.scene.ray_intersect_preliminary(ray, coherent, active)
        return dr.select(here.is_valid(), here, found)

    def of(self, shape: mi.UInt32, face: mi.UInt32, active: mi.Bool) -> tuple[mi.UInt32, mi.UInt32]:
        """Row of the material table, and number of the triangle in its own shape.

        Args:
            shape: (N,) registry number of what was met.
            face: (N,) number of its triangle.
            active: (N,) lanes that met something.
        """
        common = active & (shape == self.mesh) & (self.mesh != 0)
        row = dr.select(common, dr.gather(mi.UInt32, self.row, face, common), shape)
        return row, dr.select(common, dr.gather(mi.UInt32, self.face, face, common), face)
