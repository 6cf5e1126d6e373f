"""What an import changed or left out, for the person who wonders why it looks different."""

from __future__ import annotations

# Remarks that `ddgi.survey` looks for.
LIGHT_OPTIONS = "--sky, --sun, --env, --point or --spot"
AT_REST = "shown at rest, unless a moment is asked for (--time; `ddgi render --animation` plays them)"
NO_LIGHT = f"no light in the scene: a clear sky and its sun added, choose with {LIGHT_OPTIONS}"
PICTURE_MISSING = "picture not found"
MATERIALS_MISSING = "material file not found"


class Notes:
    """Remarks in order of first appearance; the same remark many times is one line with a count."""

    def __init__(self) -> None:
        self._counts: dict[str, int] = {}

    def add(self, remark: str) -> None:
        """Record one remark."""
        self._counts[remark] = self._counts.get(remark, 0) + 1

    def lines(self) -> tuple[str, ...]:
        """All remarks, one line each."""
        return tuple(r if n == 1 else f"{r} ({n} times)" for r, n in self._counts.items())
