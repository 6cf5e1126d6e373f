"""`ddgi scenes` and `ddgi presets`: what there is to choose from."""

from __future__ import annotations

import click


@click.command()
def scenes() -> None:
    """List the built-in scenes."""
    from ddgi.scene.library import BUILT_IN

    width = max(map(len, BUILT_IN))
    for scene in BUILT_IN.values():
        click.echo(f"{scene.name:<{width}}  {scene.summary}")


@click.command()
@click.argument("name", required=False)
def presets(name: str | None) -> None:
    """List the presets; with a NAME, print that preset as TOML, ready for --config."""
    from ddgi.preset_text import SUMMARIES, to_toml
    from ddgi.settings import PRESETS, RenderSettings

    if name is not None:
        click.echo(to_toml(RenderSettings.preset(name)), nl=False)
        return
    width = max(map(len, PRESETS))
    for preset in PRESETS:
        click.echo(f"{preset:<{width}}  {SUMMARIES[preset]}")
