"""How near `cornell-point` comes to a path-traced picture after 32 frames.

    python benchmarks/cornell_point.py [--size N] [--samples N] [--reference FILE.npy] [--preset NAME]

The reference is two independent halves; their own FLIP says how far it can be trusted. Needs
flip-evaluator, which comes with `pip install 'ddgi[test]'`.
"""

from __future__ import annotations

from pathlib import Path

import click
import numpy as np

import ddgi

FRAMES = 32
SAMPLES_PER_PASS = 64
REC709 = np.array([0.2126, 0.7152, 0.0722], np.float32)


def reference_halves(scene: ddgi.Scene, samples: int) -> np.ndarray:
    """Two path-traced halves, (2, H, W, 3): Mitsuba's `path`, box filter, no end to the bounces."""
    import mitsuba as mi

    original = mi.parser.instantiate(mi.parser.ParserConfig(mi.variant()), scene.source)
    width, height = scene.camera.size
    film = {
        "type": "hdrfilm",
        "width": width,
        "height": height,
        "rfilter": {"type": "box"},
        "pixel_format": "rgb",
    }
    to_world = mi.ScalarTransform4f().look_at([0, 0, 3.9], [0, 0, 0], [0, 1, 0])
    view = float(np.degrees(2 * np.arctan(np.array(scene.camera.right).ravel()[0])))
    sensor = mi.load_dict({"type": "perspective", "fov": view, "to_world": to_world, "film": film})
    integrator = mi.load_dict({"type": "path", "max_depth": -1})
    halves = np.zeros((2, height, width, 3))
    passes = max(2, samples // SAMPLES_PER_PASS)
    for number in range(passes):
        picture = mi.render(original, sensor=sensor, integrator=integrator, spp=SAMPLES_PER_PASS, seed=number)
        halves[number % 2] += np.array(picture)
    return (halves / (passes // 2)).astype(np.float32)


@click.command()
@click.option("--size", default=512, show_default=True)
@click.option("--samples", default=4096, show_default=True)
@click.option(
    "--reference", type=click.Path(path_type=Path), help="Keep the reference there, and use it again."
)
@click.option("--preset", default="default", show_default=True)
def main(size: int, samples: int, reference: Path | None, preset: str) -> None:
    """Print mean FLIP-HDR and luminance error."""
    import flip_evaluator

    scene = ddgi.load_scene("cornell-point", size=(size, size))
    if reference is not None and reference.exists():
        halves = np.load(reference)
    else:
        halves = reference_halves(scene, samples)
        if reference is not None:
            np.save(reference, halves)
    settings = ddgi.RenderSettings.preset(preset)
    field, frame = ddgi.IrradianceField.fit(scene, settings), None
    for tick in range(FRAMES):
        field, frame = ddgi.render_frame(scene, field, scene.camera, tick, settings, frame)
    picture, truth = frame.numpy(), halves.mean(0)
    flip = flip_evaluator.evaluate(truth, picture, "HDR")[1]
    noise = flip_evaluator.evaluate(halves[0], halves[1], "HDR")[1]
    luminance = (picture @ REC709).mean() / (truth @ REC709).mean() - 1
    print(f"{field.probes:,} probes, {FRAMES} frames: FLIP {flip:.4f}, luminance {100 * luminance:+.2f} %")
    print(f"reference: FLIP between its halves {noise:.4f}")


if __name__ == "__main__":
    main()
