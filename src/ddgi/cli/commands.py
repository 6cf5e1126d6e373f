"""All commands, gathered."""

from __future__ import annotations

import click

from ddgi import __version__
from ddgi.cli.bench import bench
from ddgi.cli.compare import compare
from ddgi.cli.debug import debug
from ddgi.cli.explain import explain
from ddgi.cli.flicker import flicker
from ddgi.cli.info import info
from ddgi.cli.listings import presets, scenes
from ddgi.cli.render import render
from ddgi.cli.respond import respond


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(__version__, message="ddgi %(version)s")
def commands() -> None:
    """Light scenes with ray-traced irradiance probes (dynamic diffuse global illumination)."""


for command in (render, info, scenes, presets, compare, explain, debug, flicker, respond, bench):
    commands.add_command(command)
