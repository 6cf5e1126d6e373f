"""A path-traced reference in two independent halves, refined until it is good enough, and kept.

Paths start at the camera, or at the lamps where that leaves less noise in the same time.

What the halves differ by is the reference's own noise (`ddgi.judge.noise`). A target counts only where
the noise in FLIP is at most half of it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter
from typing import Literal

import numpy as np

from ddgi.errors import DDGIError
from ddgi.judge import light_tracer
from ddgi.judge.cache import Key, load, make_folder, store
from ddgi.judge.metrics import flip_exposures, flip_map
from ddgi.judge.noise import luminance_noise, rel_mse_noise
from ddgi.judge.pace import Pace
from ddgi.judge.path_tracer import PathTracer
from ddgi.judge.watch import NOBODY, Watch
from ddgi.scene.camera import Camera, with_size
from ddgi.scene.scene import Scene

FIRST_SAMPLES = 8
"""Samples per pixel of each half to begin with; doubled until the noise is low enough."""
DIRECT_SHARE = {"camera": 2, "lamps": 4}
"""Direct light alone is less noisy: it takes a half or a quarter of the samples."""
PILOT_BLOCK = 8
"""Side of the blocks of pixels whose noise decides where paths start."""
MOST_SAMPLES = 2**24
PILOT_PIXELS = 2**13
"""Most pixels of the pilot: as many as tell noise, few enough to cost little."""
KEPT = ("halves", "direct", "spp", "noise", "start")
"""What is stored of a reference."""


Start = Literal["camera", "lamps"]


@dataclass(frozen=True)
class Reference:
    """Path-traced pictures of one view, (H, W, 3) radiance [W/(m^2 sr)]."""

    halves: np.ndarray  # (2, H, W, 3) means of independent samples
    direct: np.ndarray  # (H, W, 3) emission and direct light
    spp: int  # samples per pixel in both halves together
    noise: float  # mean FLIP between the halves
    start: Start  # where its paths start
    fresh: int = 0  # of its samples, those made just now and not kept from before
    sample_seconds: float = 0.0  # what one of those took; 0 where there are none

    @property
    def picture(self) -> np.ndarray:
        """The mean of both halves, (H, W, 3)."""
        return self.halves.mean(0)

    @property
    def indirect(self) -> np.ndarray:
        """What bounced at least twice, (H, W, 3); noise may make it negative."""
        return self.picture - self.direct

    @property
    def luminance_noise(self) -> float:
        """Standard error of its mean luminance, over that mean."""
        return luminance_noise(self.halves)

    @property
    def rel_mse_noise(self) -> float:
        """What its noise adds to the rel. MSE of any picture held against it."""
        return rel_mse_noise(self.halves)

    def good_for(self, target: float) -> bool:
        """Whether a mean FLIP of `target` can be told from noise."""
        return self.noise <= target / 2


def make_reference(
    scene: Scene,
    camera: Camera,
    target: float,
    most_seconds: float,
    folder: Path | None = None,
    watch: Watch = NOBODY,
) -> Reference:
    """The reference of a view: from the cache if it is good enough, else refined and kept.

    Args:
        scene: What there is; its `source` is rendered.
        camera: The view.
        target: Mean FLIP that it must be able to tell from noise.
        most_seconds: Time for new samples; the noise reached is stated in the result. The first
            samples are made however long they take.
        folder: Where references are kept; None: the default one (`ddgi.judge.cache`).
        watch: Told what is going on.

    Raises:
        DDGIError: The path-traced picture is not finite, or FLIP is not installed.
        OutputError: The reference cannot be kept.
    """
    key = Key.of(scene, camera, folder)
    known = kept(key)
    if known is not None and (known.good_for(target) or most_seconds <= 0):
        return known
    make_folder(key)  # before the work starts
    watch.phase("path tracing the reference")
    pace, tracer = Pace(most_seconds), PathTracer(scene)
    start = known.start if known is not None else _better_start(_makers(tracer, _fewer_pixels(camera)))
    make = _makers(tracer, camera)[start]
    while known is None or not known.good_for(target):
        # First a few samples, which tell how long one takes; then as many as the time left allows.
        wanted, before = FIRST_SAMPLES, 0 if known is None else known.spp // 2
        if pace.samples:
            wanted = min(before, MOST_SAMPLES - 2 * before, pace.affordable())
        if wanted < 1:
            break
        if known is not None:
            watch.phase(
                f"path tracing the reference: {2 * before:,} samples a pixel so far, FLIP {known.noise:.3f} between its "
                f"halves, {target / 2:g} needed; {pace.left:.0f} s left"
            )
        with pace.sampling(wanted):
            fresh = make(wanted, before)
        with pace.judging():
            known = _refined(known, *fresh, start, wanted)
            store(key, {name: getattr(known, name) for name in KEPT})
    assert known is not None  # the first samples are always taken
    return replace(known, sample_seconds=pace.per_sample / 2)


def kept(key: Key) -> Reference | None:
    """The reference stored under a key; None if there is none that is whole."""
    picture = (*key.shape, 3)
    found = load(key, {"halves": (2, *picture), "direct": picture})
    return Reference(**found) if found is not None and found.keys() == set(KEPT) else None


Maker = Callable[[int, int], tuple[np.ndarray, np.ndarray]]
"""From a number of samples per pixel and those made before: both halves, and direct light alone."""


def _makers(tracer: PathTracer, camera: Camera) -> dict[Start, Maker]:
    """The ways to make samples, by where paths start."""

    def direct(part: int, spp: int, before: int) -> np.ndarray:
        return tracer.render_direct(camera, spp, _seed(part, before)).picture

    def from_camera(spp: int, before: int) -> tuple[np.ndarray, np.ndarray]:
        halves = [tracer.render(camera, spp, _seed(half, before)).picture for half in range(2)]
        return np.stack(halves), direct(2, max(1, spp // DIRECT_SHARE["camera"]), before)

    if not light_tracer.suits(tracer.scene, camera):
        return {"camera": from_camera}
    lamps = light_tracer.LightTracer(tracer.scene, tracer.origin)

    def from_lamps(spp: int, before: int) -> tuple[np.ndarray, np.ndarray]:
        seen = np.stack([direct(half, max(1, spp // DIRECT_SHARE["lamps"]), before) for half in range(2)])
        indirect = [lamps.render(camera, spp, _seed(half + 2, before)).picture for half in range(2)]
        return seen + np.stack(indirect), seen.mean(0)

    return {"camera": from_camera, "lamps": from_lamps}


def _fewer_pixels(camera: Camera) -> Camera:
    """The same view in a picture of `PILOT_PIXELS` at most."""
    width, height = camera.size
    share = min(1.0, (PILOT_PIXELS / (width * height)) ** 0.5)
    return with_size(camera, (max(1, int(share * width)), max(1, int(share * height))))


def _better_start(makers: dict[Start, Maker]) -> Start:
    """Where paths start that leave the least noise for their time."""
    if len(makers) == 1:
        return next(iter(makers))
    cost = {}
    for start, make in makers.items():
        make(FIRST_SAMPLES, MOST_SAMPLES - 2 * FIRST_SAMPLES)  # compiles, and is not timed
        begin = perf_counter()
        halves, _ = make(FIRST_SAMPLES, MOST_SAMPLES - FIRST_SAMPLES)
        noise = np.abs(_blocks(halves[0]) - _blocks(halves[1])).mean()
        cost[start] = noise * noise * (perf_counter() - begin)
    return min(cost, key=lambda start: cost[start])


def _blocks(picture: np.ndarray) -> np.ndarray:
    """Means of blocks of pixels: in single ones a few bright samples among many black ones pass for little noise."""
    rows, columns = (
        np.linspace(0, n, max(1, n // PILOT_BLOCK), endpoint=False, dtype=int) for n in picture.shape[:2]
    )
    sums = np.add.reduceat(np.add.reduceat(picture.astype(np.float64), rows, 0), columns, 1)
    means: np.ndarray = sums / PILOT_BLOCK**2
    return means


def _refined(
    known: Reference | None, halves: np.ndarray, direct: np.ndarray, start: Start, spp: int
) -> Reference:
    """The reference with `spp` more samples in each half."""
    before = 0 if known is None else known.spp // 2
    if not (np.isfinite(halves).all() and np.isfinite(direct).all()):
        raise DDGIError("the path-traced reference holds values that are not numbers")
    share = before / (before + spp)
    if known is not None:
        halves, direct = (
            (share * old + (1 - share) * new).astype(np.float32)
            for old, new in ((known.halves, halves), (known.direct, direct))
        )
    noise = flip_map(halves[0], halves[1], flip_exposures(halves.mean(0))).mean()
    fresh = 2 * spp + (0 if known is None else known.fresh)
    return Reference(halves, direct, 2 * (before + spp), float(noise), start, fresh)


def _seed(part: int, before: int) -> int:
    """First seed of a run of samples: runs of the parts never overlap."""
    return (part + 1) * 2 * MOST_SAMPLES + before
