"""How the faces that light meets on its way to the cameras suit the probes: sides and thickness.

A point is lit by the eight probes of its cell. Those that stand behind the wall it lies on see the
light of the other side; only their distance maps tell them apart, and of a wall that is thin against
the spacing they cannot.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ddgi.survey.faces import Faces
from ddgi.survey.volume import Volume

THIN = 0.5
"""Of the spacing along the normal: walls thinner than this are thin."""
LEAKY = 0.1
"""Share of leaky faces from which on it is worth a word.

Measured: up to 0.03 in closed boxes, whose volume ends within their walls; 0.1 to 0.7 in buildings."""


@dataclass(frozen=True)
class Walls:
    """Shares, in [0, 1], of faces that paths from the cameras meet."""

    seen: int  # places looked at
    behind: float  # seen from behind, whether their material has two sides or not
    black: float  # seen from behind, and their material has one side
    # Of those within the volume that are not black; 0 where there are none:
    sheets: float  # without thickness
    thin: float  # thinner than `THIN` of the spacing; sheets are among them
    leaky: float  # thin, and lit by probes on the other side as well
    spacing_needed: float | None  # for fewer leaky faces than `LEAKY` [m]; None: they are, or none would do


def walls(met: Faces, volume: Volume) -> Walls | None:
    """Judge faces; None if there are none."""
    seen = met.where(met.hit)
    if not len(seen):
        return None
    lit = seen.where(~seen.black & ~volume.outside(seen.position))
    thin = lit.thickness < THIN * (np.abs(lit.normal) @ volume.spacing)
    leaky = thin & probes_behind(lit, volume)
    thinnest = np.sort(np.append(np.where(leaky, lit.thickness, np.inf), np.inf))
    needed = thinnest[int(LEAKY * len(lit))] / THIN
    return Walls(
        seen=len(seen),
        behind=float(seen.behind.mean()),
        black=float(seen.black.mean()),
        sheets=_share(lit.thickness == 0),
        thin=_share(thin),
        leaky=_share(leaky),
        spacing_needed=float(needed) if 0 < needed < np.inf else None,
    )


def _share(which: np.ndarray) -> float:
    """Of those that are true; 0 of none."""
    return float(which.mean()) if len(which) else 0.0


def probes_behind(faces: Faces, volume: Volume) -> np.ndarray:
    """(N,) whether probes light a face that stand beyond what is thick there."""
    counts, spacing, first = np.array(volume.counts), np.array(volume.spacing), np.array(volume.box[0])
    cell = np.clip(np.floor((faces.position - first) / spacing), 0, counts - 2)  # as `query` finds it
    found = np.zeros(len(faces), bool)
    for corner in np.ndindex(2, 2, 2):
        depth = ((faces.position - first - (cell + corner) * spacing) * faces.normal).sum(-1)
        found |= depth > faces.thickness + 1e-3 * min(volume.spacing)  # not those in the face itself
    return found
