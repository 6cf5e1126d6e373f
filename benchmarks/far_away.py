"""One scene in many units, near the origin and far from it: is it the same picture?

    python benchmarks/far_away.py [FOLDER]

A built-in scene with a lamp, a point light and a sun, written as glTF, OBJ and a Mitsuba dictionary of
PLY files: as it is, in millimetres, in kilometres, moved by 12,000 units, and both. Lights are scaled
along, so that radiance stays. Prints the mean FLIP of each picture from that of the file as it is, with
the same seed; below 0.001 is asked for. Pictures go to FOLDER.
"""

from __future__ import annotations

import json
import sys
from base64 import b64encode
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

import ddgi
from ddgi.judge.metrics import difference

SCENES = ("cornell", "house")
SIZE, FRAMES = (192, 144), 32
FAR = np.array([12000.3, 4000.7, -12000.1])
"""No multiple of anything, so that coordinates need all their digits."""
LAMP = ((-0.35, 0.55, 0.5), (0.4, 0.3, 0.2))
"""Place and intensity of a point light [m, W/sr]."""
SUN = ((0.2, -0.6, -1.0), 2.0)
"""The way it shines, and irradiance facing it [W/m^2]."""


@dataclass(frozen=True)
class Part:
    """A shape of one colour."""

    name: str
    positions: np.ndarray  # (V, 3) [m]
    faces: np.ndarray  # (F, 3)
    albedo: list[float]
    radiance: list[float]


@dataclass(frozen=True)
class Version:
    """The scene in other units, and elsewhere."""

    scale: float
    offset: np.ndarray  # (3,)

    def matrix(self, own: Any = None) -> np.ndarray:
        """(4, 4) from the original's place of something to its place here."""
        out = np.diag([self.scale, self.scale, self.scale, 1.0])
        out[:3, 3] = self.offset
        return out if own is None else out @ own

    def place(self, points: Any) -> np.ndarray:
        """Points of the original where they are now."""
        return self.scale * np.asarray(points, np.float64) + self.offset


NOWHERE = np.zeros(3)
VERSIONS = {
    "times 1000": Version(1e3, NOWHERE),
    "times 0.001": Version(1e-3, NOWHERE),
    "moved": Version(1.0, FAR),
    "times 1000, moved": Version(1e3, FAR),
    "times 1000, moved far": Version(1e3, 1e3 * FAR),
    "times 0.001, moved": Version(1e-3, FAR),
}


def parts(scene: ddgi.Scene) -> list[Part]:
    """The shapes of a scene."""
    import mitsuba as mi

    base, emission = (
        np.array(t).reshape(-1, 4)[:, :3] for t in (scene.materials.base, scene.materials.emission)
    )
    out = []
    shapes = {shape.id(): shape for shape in scene.mi_scene.shapes()}
    for name, row in scene.shapes.items():
        values = mi.traverse(shapes[name])
        if "vertex_positions" in values and "faces" in values:
            positions = values["vertex_positions"].numpy().reshape(-1, 3)
            faces = values["faces"].numpy().reshape(-1, 3)
        else:
            to_world = np.array(values["to_world"].matrix, np.float64).reshape(4, 4)
            corners = np.array([[-1, -1, 0, 1], [1, -1, 0, 1], [1, 1, 0, 1], [-1, 1, 0, 1]])
            positions, faces = (corners @ to_world.T)[:, :3], np.array([[0, 1, 2], [0, 2, 3]])
        out.append(
            Part(name, positions.astype(np.float64), faces, base[row].tolist(), emission[row].tolist())
        )
    return out


def camera_frame(camera: ddgi.Camera) -> np.ndarray:
    """(4, 4) right, up, backwards and place, as glTF has cameras."""
    frame = np.eye(4)
    for column, vector in enumerate((camera.right, camera.up, -camera.forward)):
        frame[:3, column] = np.ravel(vector) / np.linalg.norm(np.ravel(vector))
    frame[:3, 3] = np.ravel(camera.position)
    return frame


# Writers --------------------------------------------------------------------------------------------


def as_gltf(scene: ddgi.Scene, version: Version, folder: Path) -> ddgi.Scene:
    """Vertices are in single precision as they were; the node above them all has what is new."""
    data, views, accessors = bytearray(), [], []

    def accessor(values: np.ndarray, component: int, kind: str) -> int:
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": values.nbytes})
        data.extend(values.tobytes())
        accessors.append(
            {"bufferView": len(views) - 1, "componentType": component, "count": len(values), "type": kind}
        )
        return len(accessors) - 1

    camera, (place, power) = scene.camera, LAMP
    up = float(np.linalg.norm(np.ravel(camera.up)))
    lens = {"yfov": 2 * np.arctan(up), "aspectRatio": SIZE[0] / SIZE[1]}
    lens["znear"] = max(float(np.ravel(camera.near)[0]), 1e-3) * version.scale
    nodes: list[dict[str, Any]] = [
        {"camera": 0, "name": "camera", "matrix": camera_frame(camera).T.ravel().tolist()},
        {"translation": list(place), "extensions": {"KHR_lights_punctual": {"light": 0}}},
        {"matrix": _turned(SUN[0]).T.ravel().tolist(), "extensions": {"KHR_lights_punctual": {"light": 1}}},
    ]
    materials, meshes = [], []
    for number, part in enumerate(parts(scene)):
        strength = max(part.radiance)
        glow: dict[str, Any] = {
            "emissiveFactor": [r / (strength or 1) for r in part.radiance],
            "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": strength}},
        }
        color = {"baseColorFactor": [*part.albedo, 1], "metallicFactor": 0}
        materials.append({"pbrMetallicRoughness": color, "doubleSided": True} | (glow if strength else {}))
        position = accessor(part.positions.astype("<f4"), 5126, "VEC3")
        index = accessor(part.faces.astype("<u4").reshape(-1, 1), 5125, "SCALAR")
        primitive = {"attributes": {"POSITION": position}, "indices": index, "material": number}
        meshes.append({"primitives": [primitive]})
        nodes.append({"mesh": number, "name": part.name})
    nodes.append(
        {"children": list(range(len(nodes))), "matrix": version.matrix().T.ravel().tolist(), "name": "all"}
    )
    lights = [
        {"type": "point", "color": list(power), "intensity": version.scale**2},
        {"type": "directional", "intensity": SUN[1]},
    ]
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [len(nodes) - 1]}], "nodes": nodes,
        "meshes": meshes, "materials": materials, "accessors": accessors, "bufferViews": views,
        "cameras": [{"type": "perspective", "perspective": lens}],
        "extensions": {"KHR_lights_punctual": {"lights": lights}},
        "extensionsUsed": ["KHR_lights_punctual", "KHR_materials_emissive_strength"],
        "buffers": [{"byteLength": len(data), "uri": "data:application/octet-stream;base64," + b64encode(data).decode()}],
    }  # fmt: skip
    path = folder / "scene.gltf"
    path.write_text(json.dumps(document))
    return ddgi.load_scene(path, size=SIZE)


def as_obj(scene: ddgi.Scene, version: Version, folder: Path) -> ddgi.Scene:
    """Vertices with all digits; lights and camera are handed over."""
    obj, mtl, first = ["mtllib scene.mtl"], [], 1
    for part in parts(scene):
        colors = {"Kd": part.albedo, "Ke": part.radiance}
        mtl += [f"newmtl {part.name}", *(f"{key} {' '.join(map(str, rgb))}" for key, rgb in colors.items())]
        obj += [f"o {part.name}", f"usemtl {part.name}"]
        obj += [f"v {x!r} {y!r} {z!r}" for x, y, z in version.place(part.positions).tolist()]
        obj += [f"f {a} {b} {c}" for a, b, c in (part.faces + first).tolist()]
        first += len(part.positions)
    (folder / "scene.mtl").write_text("\n".join(mtl))
    path = folder / "scene.obj"
    path.write_text("\n".join(obj))
    eye = scene.camera
    middle = np.ravel(eye.position) + np.ravel(eye.forward)
    fov = float(np.degrees(2 * np.arctan(np.linalg.norm(np.ravel(eye.right)))))
    camera = ddgi.look_at(
        version.place(np.ravel(eye.position)), version.place(middle), np.ravel(eye.up),
        fov=fov, size=SIZE, near=float(np.ravel(eye.near)[0]) * version.scale,
    )  # fmt: skip
    return ddgi.load_scene(path, size=SIZE, camera=camera, lights=list(_lights(version).values()))


def as_dictionary(scene: ddgi.Scene, version: Version, folder: Path) -> ddgi.Scene:
    """Meshes in single precision as they were, and where they stand in double."""
    import mitsuba as mi

    place = mi.ScalarTransform4d(version.matrix())
    frame = camera_frame(scene.camera) @ np.diag([-1.0, 1.0, -1.0, 1.0])  # Mitsuba looks along +z
    frame[:3, 3] = version.place(frame[:3, 3])
    fov = float(np.degrees(2 * np.arctan(np.linalg.norm(np.ravel(scene.camera.right)))))
    sensor = {
        "type": "perspective", "fov": fov, "fov_axis": "x", "to_world": mi.ScalarTransform4d(frame),
        "near_clip": float(np.ravel(scene.camera.near)[0]) * version.scale,
        "far_clip": 1e6 * version.scale,
        "film": {"type": "hdrfilm", "width": SIZE[0], "height": SIZE[1]},
    }  # fmt: skip
    description: dict[str, Any] = {"type": "scene", "camera": sensor, **_lights(version)}
    for part in parts(scene):
        path = folder / f"{part.name}.ply"
        _write_ply(path, part)
        matt = {"type": "diffuse", "reflectance": {"type": "rgb", "value": part.albedo}}
        shape = {"type": "ply", "filename": str(path), "face_normals": True, "to_world": place}
        shape["bsdf"] = {"type": "twosided", "nested": matt}
        if max(part.radiance) > 0:
            shape["emitter"] = {"type": "area", "radiance": {"type": "rgb", "value": part.radiance}}
        description[part.name] = shape
    return ddgi.load_scene(description)


def _lights(version: Version) -> dict[str, dict[str, Any]]:
    place, power = LAMP
    bright = {"type": "rgb", "value": [version.scale**2 * p for p in power]}
    way = np.array(SUN[0]) / np.linalg.norm(SUN[0])
    return {
        "lamp": {"type": "point", "position": version.place(place).tolist(), "intensity": bright},
        "sun": {"type": "directional", "direction": way.tolist(), "irradiance": {"type": "rgb", "value": SUN[1]}},
    }  # fmt: skip


def _turned(direction: Any) -> np.ndarray:
    """(4, 4) that turns -z into a direction."""
    back = -np.array(direction) / np.linalg.norm(direction)
    across = np.cross([0.0, 1.0, 0.0], back)
    across /= np.linalg.norm(across)
    out = np.eye(4)
    out[:3, :3] = np.stack([across, np.cross(back, across), back], 1)
    return out


def _write_ply(path: Path, part: Part) -> None:
    names = "".join(f"property float {axis}\n" for axis in "xyz")
    header = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(part.positions)}\n{names}"
        f"element face {len(part.faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    rows = np.zeros(len(part.faces), [("n", "u1"), ("corners", "<i4", 3)])
    rows["n"], rows["corners"] = 3, part.faces
    path.write_bytes(header.encode() + part.positions.astype("<f4").tobytes() + rows.tobytes())


# Measuring ------------------------------------------------------------------------------------------

Writer = Callable[[ddgi.Scene, Version, Path], ddgi.Scene]
WRITERS: dict[str, tuple[Writer, bool]] = {
    "glTF": (as_gltf, False),
    "OBJ": (as_obj, False),
    "dictionary": (as_dictionary, False),
    "glTF, fitted": (as_gltf, True),
}
"""And whether probes stand where ddgi fits them, or in the box that the built-in scene names."""


def picture(scene: ddgi.Scene, box: Any) -> ddgi.Frame:
    """Frames of a scene, added up. `box`: where probes stand; None: fitted."""
    settings = ddgi.RenderSettings.preset("default")
    settings = replace(settings, grid=replace(settings.grid, budget=1024, box=box))
    field = ddgi.IrradianceField.fit(scene, settings)
    frame = None
    for tick in range(FRAMES):
        field, frame = ddgi.render_frame(scene, field, scene.camera, tick, settings, frame)
    assert frame is not None
    return frame


def main() -> None:
    """Render all and print a table."""
    out = Path(sys.argv[1]) if len(sys.argv) > 1 else None
    print(f"{'':24}" + "".join(f"{name:>24}" for name in VERSIONS))
    for name in SCENES:
        original = ddgi.load_scene(name, size=SIZE)
        for kind, (write, fitted) in WRITERS.items():
            shown = {}
            for version, change in {"as it is": Version(1.0, NOWHERE), **VERSIONS}.items():
                box = None if fitted else tuple(tuple(side) for side in change.place(original.box).tolist())
                with TemporaryDirectory() as folder:
                    shown[version] = picture(write(original, change, Path(folder)), box)
            truth = shown["as it is"].numpy()
            found = [difference(shown[version].numpy(), truth).flip_mean for version in VERSIONS]
            print(f"{name:8}{kind:16}" + "".join(f"{error:24.5f}" for error in found), flush=True)
            for version, frame in shown.items() if out is not None else ():
                ddgi.save(out / f"{name}-{kind}-{version.replace(', ', '-').replace(' ', '-')}.png", frame)


if __name__ == "__main__":
    main()
