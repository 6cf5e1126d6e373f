"""The command line: `ddgi render`, `info`, `scenes`, `presets`, `compare`, `flicker`, `respond` and `bench`.

Every failure ends as one readable line and an exit code: 1 for what the package refuses, 2 for a
wrong use of the command line, 130 after Ctrl-C. `--debug` shows the traceback.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

from ddgi.cli.interrupts import noticing_interrupts

FAILED, MISUSED, INTERRUPTED = 1, 2, 130


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; the exit code.

    Args:
        arguments: Without the program's name; by default those of the process.
    """
    given = list(sys.argv[1:] if arguments is None else arguments)
    with noticing_interrupts() as interrupted:
        try:
            # Imported here, so that Ctrl-C during the imports is noticed too.
            from ddgi.cli.commands import commands

            code = commands.main(args=given, prog_name="ddgi", standalone_mode=False)
            sys.stdout.flush()
            return code if isinstance(code, int) else 0
        except BrokenPipeError:
            # Whoever read our output has enough of it; point stdout away so that exiting cannot fail too.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return FAILED
        except (Exception, KeyboardInterrupt) as error:
            if interrupted.is_set() or isinstance(error, KeyboardInterrupt):
                return _end("interrupted", INTERRUPTED, given)
            from ddgi.cli.messages import is_misuse, text

            return _end(text(error), MISUSED if is_misuse(error) else FAILED, given)


def _end(text: str, code: int, arguments: Sequence[str] = ()) -> int:
    """Print one line, after the traceback if that is asked for."""
    if "--debug" in arguments:
        import traceback

        traceback.print_exc()
    sys.stderr.write("ddgi: " + " ".join(text.split()) + "\n")
    return code
