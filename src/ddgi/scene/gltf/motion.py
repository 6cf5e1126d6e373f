"""Animations and skins of a file, read and checked for whoever plays them.

glTF 2.0 specification, sections 3.7.3 (skins) and 3.11 (animations).
"""

from __future__ import annotations

import numpy as np

from ddgi.errors import SceneError
from ddgi.scene.gltf.accessors import Accessors
from ddgi.scene.gltf.schema import Animation, AnimationSampler, Document
from ddgi.scene.notes import Notes
from ddgi.scene.rig import Channel, Clip, Skin

PATHS = {"translation": ("VEC3",), "rotation": ("VEC4",), "scale": ("VEC3",), "weights": ("SCALAR",)}


def read_clips(document: Document, accessors: Accessors, notes: Notes) -> tuple[Clip, ...]:
    """All animations.

    Raises:
        SceneError: One has no samplers for its channels, or another number of values than times.
    """
    return tuple(
        _clip(animation, f"animations[{number}]", accessors, notes)
        for number, animation in enumerate(document.animations)
    )


def read_skins(document: Document, accessors: Accessors) -> tuple[Skin, ...]:
    """All skins.

    Raises:
        SceneError: One has not as many matrices as joints, or one that is no placement.
    """
    skins = []
    for skin in document.skins:
        matrices = np.tile(np.eye(4), (len(skin.joints), 1, 1))
        if skin.inverse_bind_matrices is not None:
            index = skin.inverse_bind_matrices
            stored = accessors.floats(index, ("MAT4",))
            if len(stored) < len(skin.joints):
                raise SceneError(f"{accessors.label(index)}: {len(stored)} for {len(skin.joints)} joints")
            columns = stored[: len(skin.joints)].astype(np.float64).reshape(-1, 4, 4)
            matrices = columns.transpose(0, 2, 1)
            if not np.allclose(matrices[:, 3], [0, 0, 0, 1], atol=1e-4):
                raise SceneError(
                    f"{accessors.label(index)}: a matrix is no placement: its last row must be 0, 0, 0, 1"
                )
        skins.append(Skin(tuple(skin.joints), matrices))
    return tuple(skins)


def _clip(animation: Animation, label: str, accessors: Accessors, notes: Notes) -> Clip:
    channels = []
    for number, channel in enumerate(animation.channels):
        where = f"{label}.channels[{number}]"
        if channel.sampler >= len(animation.samplers):
            raise SceneError(f"{where} names sampler {channel.sampler} of {len(animation.samplers)}")
        if channel.target.node is None or channel.target.path not in PATHS:
            notes.add("a channel of an animation that moves no node is left out")
            continue
        sampler, path = animation.samplers[channel.sampler], channel.target.path
        times, values = _keys(sampler, PATHS[path], accessors, where)
        if times[0] < 0 or (np.diff(times) <= 0).any():
            notes.add("a channel of an animation whose times do not rise from 0 on is left out")
            continue
        channels.append(Channel(channel.target.node, path, sampler.interpolation, times, values))
    return Clip(animation.name or label, tuple(channels))


def _keys(
    sampler: AnimationSampler, kinds: tuple[str, ...], accessors: Accessors, where: str
) -> tuple[np.ndarray, np.ndarray]:
    """Times and values of a sampler, shaped as `Channel` has them."""
    times = accessors.floats(sampler.input, ("SCALAR",))[:, 0]
    values = accessors.floats(sampler.output, kinds)
    spline = sampler.interpolation == "CUBICSPLINE"
    rows = len(times) * (3 if spline else 1)
    if len(values) % rows or (kinds != ("SCALAR",) and len(values) != rows):
        raise SceneError(f"{where}: {len(values)} values for {len(times)} times")
    shape = (len(times), 3, -1) if spline else (len(times), -1)
    return times, values.reshape(shape)
