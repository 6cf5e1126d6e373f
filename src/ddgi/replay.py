"""Replaying a stage: traced by Dr.Jit once, then run from the recording.

Three defects of `dr.freeze` (Dr.Jit 1.5) are kept from the stages here. It overlooks a changed number,
flag or name among the inputs if the same Python object occurs among them twice, and then replays the
recording of other settings; it refuses to replay once Mitsuba objects have come or gone; and where as
many have come as have gone, it does replay, and reads freed memory.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass
from functools import cache
from typing import Any

import drjit as dr

KEPT = 32
"""Recordings kept of a function; the one longest unused goes first."""


class Replayed:
    """A function of Dr.Jit arrays and constants, recorded once for each set of constants."""

    def __init__(self, function: Callable[..., Any]) -> None:
        """Nothing is recorded before the first call."""
        # Settings change because somebody changes them: no reason for Dr.Jit to warn.
        self._frozen = dr.freeze(
            lambda _constants, *arguments: function(*arguments), limit=KEPT, warn_after=2**31 - 1
        )
        self._serial: int | None = None

    def __call__(self, settings: Any, *arguments: Any) -> Any:
        """Call the function with `arguments`, then `settings`.

        Args:
            settings: Frozen dataclass of constants.
            arguments: Arrays, Mitsuba objects, constants, and dataclasses, lists and dictionaries of them. One
                with a `serial` says which scene Mitsuba's objects belong to.
        """
        # Recordings of one scene are good for no other: see above.
        serial = next((a.serial for a in arguments if hasattr(a, "serial")), None)
        if serial != self._serial:
            self._frozen.clear()
            self._serial = serial
        # A string made for the occasion occurs once, so it is always compared.
        constants = repr(settings) + repr(list(_constants(arguments)))
        try:
            return self._frozen(constants, *arguments, settings)
        except RuntimeError as error:
            if "registry" not in f"{error} {error.__cause__}":
                raise
            # Another scene was loaded or dropped: Mitsuba's registry of objects is not what it was. Or a
            # lamp has a texture: its first recording fails over the registry, the next does not.
            self._frozen.clear()
            return self._frozen(constants, *arguments, settings)

    @property
    def recordings(self) -> int:
        """How often the function has been recorded."""
        return int(self._frozen.n_recordings)


def _constants(value: Any) -> Iterator[Any]:
    """Everything in a tree of inputs that is neither an array nor a Mitsuba object, in order."""
    kind: Any = type(value)
    if value is None or kind in PLAIN:
        yield value
    elif kind is dict:
        yield from value
        yield from _constants(list(value.values()))
    elif kind in (list, tuple):
        for item in value:
            yield from _constants(item)
    else:
        for name in _field_names(kind):
            yield from _constants(getattr(value, name))


PLAIN = frozenset((bool, int, float, str))


@cache
def _field_names(kind: Any) -> tuple[str, ...]:
    """Names of a dataclass's fields; none of anything else. Asking every time would cost a tenth of a millisecond."""
    return tuple(field.name for field in fields(kind)) if is_dataclass(kind) else ()
