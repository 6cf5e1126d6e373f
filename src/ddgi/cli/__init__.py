"""The command line: `ddgi render`, `scenes`, `presets` and `bench`.

Every failure ends as one readable line and an exit code: 1 for what the package refuses, 2 for a
wrong use of the command line, 130 after Ctrl-C. `--debug` shows the traceback.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

import click

from ddgi import __version__
from ddgi.cli.bench import bench
from ddgi.cli.interrupts import noticing_interrupts
from ddgi.cli.listings import presets, scenes
from ddgi.cli.render import render
from ddgi.errors import DDGIError

FAILED, MISUSED, INTERRUPTED = 1, 2, 130


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(__version__, message="ddgi %(version)s")
def commands() -> None:
    """Light scenes with ray-traced irradiance probes (dynamic diffuse global illumination)."""


for command in (render, scenes, presets, bench):
    commands.add_command(command)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; the exit code.

    Args:
        arguments: Without the program's name; by default those of the process.
    """
    given = list(sys.argv[1:] if arguments is None else arguments)
    with noticing_interrupts() as interrupted:
        try:
            code = commands.main(args=given, prog_name="ddgi", standalone_mode=False)
            sys.stdout.flush()
            return code if isinstance(code, int) else 0
        except BrokenPipeError:
            # Whoever read our output has enough of it; point stdout away so that exiting cannot fail too.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return FAILED
        except (Exception, KeyboardInterrupt) as error:
            if interrupted.is_set() or isinstance(error, (click.Abort, KeyboardInterrupt)):
                return _end("interrupted", INTERRUPTED, given)
            return _end(_text(error), MISUSED if isinstance(error, click.UsageError) else FAILED, given)


def _text(error: Exception) -> str:
    """What to print about an error."""
    match error:
        case click.exceptions.NoArgsIsHelpError():
            return "error: say what to do: render, scenes, presets or bench (see ddgi --help)"
        case click.UsageError():
            return _usage_text(error)
        case DDGIError():
            return f"error: {error}"
        case MemoryError():
            return "error: out of memory: render smaller or use fewer probes"
    return f"error: unexpected {type(error).__name__}: {error} (run again with --debug to see where)"


def _usage_text(error: click.UsageError) -> str:
    command = error.ctx.command_path if error.ctx else "ddgi"
    return f"error: {error.format_message()} (see {command} --help)"


def _end(text: str, code: int, arguments: Sequence[str] = ()) -> int:
    """Print one line, after the traceback if that is asked for."""
    if "--debug" in arguments:
        import traceback

        traceback.print_exc()
    click.echo("ddgi: " + " ".join(text.split()), err=True)
    return code
