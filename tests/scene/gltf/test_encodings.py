"""One asset in five encodings is one scene: the same geometry, and the same picture."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from ddgi import load_scene
from ddgi.config import load_settings
from ddgi.passes.tone import tone_map
from ddgi.still import still
from gltf_writing import shapes_of

HERE = Path(__file__).parent / "encodings"
EXACT, QUANTIZED = ("sparse",), ("quantized", "draco", "meshopt")
NEEDED = {"draco": "DracoPy", "meshopt": "meshoptimizer"}
TOLERANCE = 1e-3
"""Of the bounds; gltf-transform keeps 14 bits of positions: 6e-5."""
SAME_DIRECTION = 0.03
"""Between unit normals: octahedral ones of 8 bits are off by up to 0.01, which uneven scales of nodes stretch."""


def file(name):
    if name in NEEDED:
        pytest.importorskip(NEEDED[name], reason=f"{NEEDED[name]} is not installed: pip install 'ddgi[gltf]'")
    return HERE / f"{name}.glb"


def corners(name, key="positions"):
    """(F, 3, C) positions, or what else vertices have, of all corners of triangles."""
    found = [shape for label, shape in sorted(shapes_of(file(name)).items()) if label]
    return np.concatenate([shape[key][shape["faces"]] for shape in found])


def matches(found, wanted):
    """For each triangle the nearest of the others in any turn, never mirrored: which, its turn, and how far."""
    turned = np.stack([np.roll(wanted, -turn, 1) for turn in range(3)], 1)
    far = np.abs(found[:, None, None] - turned[None]).max((-1, -2))
    which, turn = np.unravel_index(far.reshape(len(found), -1).argmin(1), far.shape[1:])
    return which, turn, far[np.arange(len(found)), which, turn]


@pytest.mark.parametrize("name", EXACT)
def test_float_encodings_are_exact(name):
    ours, plain = shapes_of(file(name)), shapes_of(file("plain"))
    assert ours.keys() == plain.keys()
    for label, shape in plain.items():
        if label:
            for key, values in shape.items():
                np.testing.assert_array_equal(ours[label][key], values, err_msg=f"{label}: {key}")


@pytest.mark.parametrize("name", QUANTIZED)
def test_quantised_encodings_are_near(name):
    """Encoders order triangles as they like, and start them at any corner."""
    ours, plain = corners(name), corners("plain")
    assert len(ours) == len(plain) == 3 * 128
    size = np.ptp(plain.reshape(-1, 3), axis=0).max()
    which, turn, far = matches(ours, plain)
    assert far.max() <= TOLERANCE * size
    assert len(np.unique(which)) == len(plain), "none twice, none lost"
    for key, most in (("normals", SAME_DIRECTION), ("texcoords", TOLERANCE)):
        theirs = corners("plain", key)[which]
        theirs = np.stack([np.roll(c, -t, 0) for c, t in zip(theirs, turn, strict=True)])
        shown = np.linalg.norm(corners(name, key) - theirs, axis=-1)
        if key == "texcoords":  # the mirrored sheet has no picture
            shown = shown[corners(name, key).reshape(len(shown), -1).any(1)]
        assert len(shown) >= 2 * 128
        assert shown.max() <= most, key


def test_a_mirrored_triangle_is_no_match():
    plain = corners("plain")
    assert matches(plain[:, ::-1], plain)[2].min() > TOLERANCE


@cache
def picture(name):
    """(90, 160, 3) as on a display, in [0, 1]."""
    box = "grid.box=[[-1.6,-1,-1.7],[1.6,1.3,1.6]]"  # the walls of others may lie a hair beside
    settings = load_settings("default", None, [box, "tone.exposure=3", "rays.per_probe=32"])
    scene = load_scene(file(name), size=(160, 90))
    frame = still(scene, settings, 4, lambda: None).frame
    return tone_map(frame.numpy(), settings.tone)


@pytest.mark.parametrize("name", EXACT)
def test_float_encodings_give_the_very_same_picture(name):
    np.testing.assert_array_equal(picture(name), picture("plain"))


@pytest.mark.parametrize("name", QUANTIZED)
def test_quantised_encodings_give_the_same_picture(name):
    """Single pixels at edges see something else; on the whole it is within 1e-3 of full white."""
    assert picture("plain").max() > 0.9
    assert np.abs(picture(name) - picture("plain")).mean() < TOLERANCE
    assert np.abs(picture("plain")[:, ::-1] - picture("plain")).mean() > 50 * TOLERANCE
