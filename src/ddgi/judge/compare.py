"""Field against reference: the same camera, lights and materials, in numbers and pictures."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import drjit as dr
import mitsuba as mi

from ddgi import __version__
from ddgi.config import as_table
from ddgi.errors import SettingsError
from ddgi.judge import denoiser
from ddgi.judge.cache import Key
from ddgi.judge.leak import Share, dark, leak
from ddgi.judge.metrics import Difference, difference, load_flip
from ddgi.judge.path_tracer import PathTracer
from ddgi.judge.reference import Reference, make_reference
from ddgi.judge.rival import Rival, in_steps, kept_samples, rival, sample_ms, samples_in
from ddgi.judge.trial import Outcome, Trial, run
from ddgi.judge.view import View, look, remarks
from ddgi.judge.watch import NOBODY, Watch
from ddgi.passes import tone
from ddgi.plural import counted
from ddgi.scene.scene import Scene

TOO_BRIGHT = 0.05
"""Error of the mean luminance from which on a picture is too bright as a whole."""
FORGOTTEN = 0.01
"""Share of the first update in the field that does no harm."""
RIVAL_SEEDS = (1 << 30, (1 << 30) + (1 << 20))
"""First seeds of the rivals: none of the reference's samples are among theirs."""


@dataclass(frozen=True)
class Judged:
    """A configuration and its difference from the reference."""

    outcome: Outcome
    difference: Difference  # of the mean of all frames
    single: Difference  # of one frame of the converged field
    leak: Share  # indirect light from probes that do not see what they light
    dark: Share  # indirect light that is missing

    def figures(self) -> dict[str, Any]:
        """All numbers by name."""
        return (
            self.difference.figures()
            | {"leak": self.leak.figures(), "dark": self.dark.figures()}
            | {"frame_flip_mean": self.single.flip_mean}
            | self.outcome.figures()
        )


@dataclass(frozen=True)
class Comparison:
    """Everything one `ddgi compare` finds out."""

    scene: Scene
    target: float  # mean FLIP asked for
    reference: Reference
    judged: list[Judged]  # at least one, in the order asked for
    rivals: dict[str, Rival]  # "frame" and "still", of the first configuration; empty if not asked for
    notes: list[str]  # what to know, a line each

    @property
    def valid(self) -> bool:
        """Whether the reference shows anything, and is good enough for the target."""
        return bool(self.reference.picture.any()) and self.reference.good_for(self.target)

    def figures(self) -> dict[str, Any]:
        """All numbers by name; those of the first configuration at the top."""
        return (
            {
                "scene": self.scene.name,
                "camera": self.scene.camera.name,
                "size": list(self.scene.camera.size),
                "target": self.target,
                "reference_spp": self.reference.spp,
                "reference_start": self.reference.start,
                "reference_flip": self.reference.noise,
                "reference_luminance": self.reference.luminance_noise,
                "reference_rel_mse": self.reference.rel_mse_noise,
                "valid": self.valid,
                "configuration": self.judged[0].outcome.trial.name,
                "seed": self.judged[0].outcome.trial.settings.seed,
                "backend": mi.variant(),
                "versions": {"ddgi": __version__, "mitsuba": mi.__version__, "drjit": dr.__version__},
            }
            | self.judged[0].figures()
            | {
                "rival": {name: found.figures() for name, found in self.rivals.items()},
                "configurations": {
                    j.outcome.trial.name: j.figures() | {"settings": as_table(j.outcome.trial.settings)}
                    for j in self.judged
                },
                "notes": self.notes,
            }
        )


def compare(
    scene: Scene,
    trials: Sequence[Trial],
    *,
    frames: int = 64,
    target: float = 0.05,
    most_seconds: float = 120.0,
    rivals: bool = True,
    folder: Path | None = None,
    watch: Watch = NOBODY,
) -> Comparison:
    """Judge configurations against one reference.

    Args:
        scene: What there is; its first camera is looked through.
        trials: Configurations, one at least.
        frames: How many each of them renders.
        target: Mean FLIP that the reference must be able to tell from noise.
        most_seconds: Time for the reference; where it is not enough, `valid` is false.
        rivals: Path trace and denoise in the time of the first configuration too.
        folder: Where references are kept; None: the default one.
        watch: Told how far it is.

    Raises:
        DDGIError: FLIP or the denoiser is not installed, or a picture holds values that are not numbers.
        SettingsError: A configuration is impossible, or there is none, or no frame.
        OutputError: The reference cannot be kept.
    """
    if frames < 1 or not trials:
        raise SettingsError("a comparison needs one configuration and one frame at least")
    load_flip()  # before the work starts
    truth = make_reference(scene, scene.camera, target, most_seconds, folder, watch)
    view = look(scene)
    judged: list[Judged] = []
    for trial in trials:
        same = next((j for j in judged if j.outcome.trial.settings == trial.settings), None)
        judged.append(_renamed(same, trial) if same else _judged(scene, trial, frames, truth, view, watch))
    notes = [*scene.notes, *remarks(view), *_doubts(truth, target, judged)]
    found = {}
    rivals = rivals and bool(truth.picture.any())  # of black nothing is learnt
    if rivals and not denoiser.installed():
        notes.append(f"no rival: {denoiser.MISSING}")
    elif rivals:
        watch.phase("path tracing the rivals")
        found = _rivals(scene, judged[0].outcome, truth, view.guides, folder)
    return Comparison(scene, target, truth, judged, found, notes)


def _judged(scene: Scene, trial: Trial, frames: int, truth: Reference, view: View, watch: Watch) -> Judged:
    """Rendered, and held against the reference."""
    watch.phase(f"rendering {trial.name}", frames)
    outcome = run(scene, trial, frames, watch)
    albedo = view.guides.albedo
    return Judged(
        outcome,
        difference(outcome.picture, truth.picture),
        difference(outcome.single, truth.picture),
        leak(outcome.leaked, truth, albedo),
        dark(outcome.indirect, truth, albedo),
    )


def _renamed(judged: Judged, trial: Trial) -> Judged:
    """The same again under another name: a sweep may pass through the values of its preset."""
    return replace(judged, outcome=replace(judged.outcome, trial=trial))


def _rivals(scene: Scene, ours: Outcome, truth: Reference, guides, folder: Path | None) -> dict[str, Rival]:
    """Both rivals of one outcome."""
    tracer, camera = PathTracer(scene), scene.camera
    cost = sample_ms(tracer, camera)
    few, many = samples_in(ours.frame_ms, cost), in_steps(samples_in(ours.frame_ms * ours.frames, cost))
    key = Key.of(scene, camera, folder)
    samples = {
        "frame": tracer.render(camera, few, RIVAL_SEEDS[0]),
        "still": kept_samples(tracer, camera, many, RIVAL_SEEDS[1], cost, key),
    }
    return {name: rival(those, guides, truth.picture) for name, those in samples.items()}


def _doubts(truth: Reference, target: float, judged: Sequence[Judged]) -> list[str]:
    """What keeps the numbers from counting."""
    lines = []
    if not truth.picture.any():
        lines.append("the reference is black: there is nothing to compare with")
        lit = [
            f"{j.outcome.trial.name} ({j.outcome.picture.mean():.2g})"
            for j in judged
            if j.outcome.picture.any()
        ]
        if lit:
            lines.append(f"not black, and so wrong as a whole: {', '.join(lit)} [mean radiance, W/m^2/sr]")
    elif not truth.good_for(target):
        lines.append(
            f"the reference is too noisy for a target of {target:g}: FLIP {truth.noise:.3f} between its halves "
            f"after {counted(truth.spp, 'sample')} a pixel, {target / 2:g} needed, which takes {_times(truth, target):,} times the samples or more{_seconds(truth, target)}: "
            "give it more time, or a smaller picture"
        )
    lines += [*_all_warm_up(judged), *_still_dark(judged), *_off(judged), *_toned(judged)]
    if truth.picture.any():
        lines += [f"{j.outcome.trial.name}: {j.outcome.remark}" for j in judged if j.outcome.remark]
    for j in judged:
        if j.outcome.non_finite:
            lines.append(
                f"{j.outcome.trial.name}: {j.outcome.non_finite} values were not numbers; taken as black"
            )
    return lines


def _times(truth: Reference, target: float) -> int:
    """How many times the samples halve the noise often enough: it falls with their square root at best."""
    return max(2, math.ceil((2 * truth.noise / target) ** 2))


def _seconds(truth: Reference, target: float) -> str:
    """What that takes, if samples were made that tell."""
    seconds = (_times(truth, target) - 1) * truth.spp * truth.sample_seconds
    return f" (some {math.ceil(seconds):,} s)" if seconds else ""


def _off(judged: Sequence[Judged]) -> list[str]:
    """Where to look for the reason if a whole picture is too bright."""
    by_maps = [j for j in judged if j.outcome.trial.settings.query.sight == "maps"]
    if all(j.difference.luminance_error < TOO_BRIGHT for j in by_maps):
        return []
    return [
        "too bright as a whole: light may leak through thin walls, of which `ddgi info` tells; query.sight=rays stops it"
    ]


def _toned(judged: Sequence[Judged]) -> list[str]:
    """That nothing here is shown as the settings would have it."""
    if all(j.outcome.trial.settings.tone == tone.Settings() for j in judged):
        return []
    return ["tone changes nothing in a comparison: every picture is shown as suits the reference"]


def _still_dark(judged: Sequence[Judged]) -> list[str]:
    """Configurations without a warm-up that still remember the darkness they began with, a line each."""
    lines = []
    for outcome in (j.outcome for j in judged):
        s = outcome.trial.settings.blend
        left = s.hysteresis ** (outcome.frames - 1) if s.warm_up == 0 else 0.0
        if left > FORGOTTEN:
            lines.append(
                f"{outcome.trial.name}: after {counted(outcome.frames, 'frame')} {100 * left:.0f} % of the first, "
                "too dark update is left in the field, and more of later bounces: ask for more frames, "
                "or set blend.warm_up=16"
            )
    return lines


def _all_warm_up(judged: Sequence[Judged]) -> list[str]:
    """Configurations whose frames are over before the field blends anything, a line for each warm-up."""
    names: dict[int, list[str]] = {}
    for outcome in (j.outcome for j in judged):
        if outcome.frames <= (warm_up := outcome.trial.settings.blend.warm_up):
            names.setdefault(warm_up, []).append(outcome.trial.name)
    frames = counted(judged[0].outcome.frames, "frame")
    return [
        f"{', '.join(those)}: {frames}, no more than the warm-up (blend.warm_up={warm_up}), in which "
        "blend.hysteresis and blend.gamma change nothing: ask for more frames"
        for warm_up, those in names.items()
    ]
