"""What is printed about an error."""

from __future__ import annotations

import click

from ddgi.errors import DDGIError


def is_misuse(error: BaseException) -> bool:
    """Whether the command line itself was wrong."""
    return isinstance(error, click.UsageError)


def text(error: BaseException) -> str:
    """An error for people, in one line."""
    match error:
        case click.exceptions.NoArgsIsHelpError():
            return "error: say what to do: render, info, compare, explain, debug, flicker, respond, bench, scenes or presets (see ddgi --help)"
        case click.UsageError():
            command = error.ctx.command_path if error.ctx else "ddgi"
            return f"error: {error.format_message()} (see {command} --help)"
        case DDGIError():
            return f"error: {error}"
        case MemoryError():
            return "error: out of memory: render smaller or use fewer probes"
        case OSError(strerror=str(reason)):
            return f"error: {reason}" + (f": {error.filename}" if error.filename else "")
    return f"error: unexpected {type(error).__name__}: {error} (run again with --debug to see where)"
