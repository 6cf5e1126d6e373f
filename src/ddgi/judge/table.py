"""A comparison as a table for people."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ddgi.judge.compare import Comparison, Judged
from ddgi.judge.reference import Reference
from ddgi.plural import counted

DOUBTED = "?"
"""Behind a FLIP that is less than twice the reference's noise."""
SAME_FLIP, SAME_TIME = 0.02, 0.1
"""Shares by which configurations must differ to differ: single timings, and one seed."""
TERMS = (
    "FLIP: difference as eyes see it, 0 to 1, mean of the pixels (p99: exceeded by one in a hundred; one frame: of a single frame)",
    "luminance: mean against the reference's; rel. MSE: squared error over the squared reference; MFF: difference on screen, "
    "summed over R, G, B, 0 to 3",
    "leak, dark: indirect light from probes hidden from what they light, and light that is missing, of the reference's mean; "
    "MB: memory of the probes",
)
COLUMNS = (
    "FLIP",
    "p99",
    "one frame",
    "luminance",
    "rel. MSE",
    "MFF mean",
    "MFF max",
    "leak",
    "dark",
    "ms/frame",
    "MB",
)


def table(found: Comparison) -> str:
    """A row for each configuration; those that no other beats in error, time and memory carry a star.

    Of a black reference nothing but that.
    """
    width = max(len(j.outcome.trial.name) for j in found.judged) + 2
    if not found.reference.picture.any():
        return "\n".join(reference_lines(found))
    noise = found.reference.noise
    best = front(found.judged, noise) if len(found.judged) > 1 else set()
    lines = [" " * width + "".join(f"{title:>11}" for title in COLUMNS)]
    for number, j in enumerate(found.judged):
        name = j.outcome.trial.name + ("*" if number in best else "")
        lines.append(f"{name:<{width}}" + "".join(f"{cell:>11}" for cell in _cells(j, noise)))
    rivals = list(_rival_lines(found))
    if any(DOUBTED in line for line in [*lines, *rivals]):
        lines.append(f"{DOUBTED} the reference's own noise may be more than half of it")
    if best:
        lines.append(
            "* no other configuration is at least as good in FLIP, ms/frame and MB, and better in one (FLIPs closer than "
            f"{100 * SAME_FLIP:.0f} % or below what the reference can tell, and times closer than {100 * SAME_TIME:.0f} %, count as the same)"
        )
    lines += ["", *TERMS, "", *reference_lines(found), *rivals]
    return "\n".join(lines)


def _rival_lines(found: Comparison) -> Iterator[str]:
    """What a path tracer makes of the first configuration's time; whole samples do not fit it exactly."""
    first, noise = found.judged[0], found.reference.noise
    flip = lambda d: f"{d.flip_mean:.4f}{doubted(d.flip_mean, noise)}"  # noqa: E731
    ours = {
        "frame": (first.single, first.outcome.frame_ms),
        "still": (first.difference, first.outcome.frame_ms * first.outcome.frames),
    }
    for name, r in found.rivals.items():
        apart, ms = ours[name]
        yield (
            f"rival, {name}: {counted(r.spp, 'sample')} a pixel in {r.ms:.0f} ms, denoised in {r.denoise_ms:.0f} ms more: "
            f"FLIP {flip(r.difference)}; {first.outcome.trial.name} in {ms:.0f} ms: {flip(apart)}"
        )


def reference_lines(found: Comparison) -> list[str]:
    """How good the reference is, and what its own noise makes of the figures."""
    truth = found.reference
    if not truth.picture.any():
        return [
            f"reference: black, {counted(truth.spp, 'path')} a pixel from the {truth.start}: nothing to compare with"
        ]
    verdict = "good enough" if found.valid else "NOT good enough"
    return [
        f"reference: {counted(truth.spp, 'path')} a pixel from the {truth.start} ({_kept(truth)}), FLIP {truth.noise:.4f} between its halves: "
        f"{verdict} for a target of {found.target:g}",
        f"its noise: luminance +- {100 * truth.luminance_noise:.2g} %, rel. MSE + {truth.rel_mse_noise:.4f}",
    ]  # fmt: skip


def _kept(truth: Reference) -> str:
    if truth.fresh in (0, truth.spp):
        return "new" if truth.fresh else "kept from before"
    return f"{truth.fresh:,} of them new"


def doubted(flip: float, noise: float) -> str:
    """A mark behind a FLIP that the reference's noise cannot carry."""
    return DOUBTED if flip < 2 * noise else ""


def front(judged: Sequence[Judged], noise: float) -> set[int]:
    """Numbers of the configurations on the front of cost against error; what noise hides counts as the same."""
    costs = [
        (max(j.difference.flip_mean, 2 * noise), j.outcome.frame_ms, j.outcome.figures()["field_mb"])
        for j in judged
    ]
    same = (SAME_FLIP, SAME_TIME, 0.0)

    def beaten(a: tuple[float, ...], b: tuple[float, ...]) -> bool:
        pairs = list(zip(a, b, same, strict=True))
        return all(y <= x * (1 + s) for x, y, s in pairs) and any(y < x * (1 - s) for x, y, s in pairs)

    return {i for i, a in enumerate(costs) if not any(beaten(a, b) for b in costs)}


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %" if share >= 0.1 else f"{100 * share:.2g} %"


def _cells(j: Judged, noise: float) -> list[str]:
    d, cost = j.difference, j.outcome.figures()
    flip = lambda x: f"{x:.4f}{doubted(x, noise)}"  # noqa: E731
    return [
        flip(d.flip_mean), f"{d.flip_p99:.3f}", flip(j.single.flip_mean), f"{100 * d.luminance_error:+.1f} %",
        f"{d.rel_mse:.4f}", f"{d.mff_mean:.4f}", f"{d.mff_max:.3f}",
        _percent(j.leak.mean), _percent(j.dark.mean), f"{cost['frame_ms']:.1f}", f"{cost['field_mb']:.1f}",
    ]  # fmt: skip
