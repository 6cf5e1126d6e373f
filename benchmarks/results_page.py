"""Write docs/results.md: the words of docs/results.template.md, the tables from docs/results/*.json.

    python benchmarks/results_page.py

A line `{{name}}` in the template becomes the table of that name. A study that was not run says so.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

DOCS = Path(__file__).parents[1] / "docs"
Rows = list[dict[str, Any]]


def load(name: str) -> dict[str, Any] | None:
    """What a study found; None if it was not run."""
    path = DOCS / "results" / f"{name}.json"
    return json.loads(path.read_text()) if path.exists() else None


def table(head: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """A table in Markdown."""
    line = lambda cells: "| " + " | ".join(map(str, cells)) + " |"  # noqa: E731
    return "\n".join([line(head), line(["---"] * len(head)), *map(line, rows)])


def quality(rows: Rows) -> str:
    """A scene a row: error, rivals, the preset for stills, reference."""
    head = (
        "scene", "materials", "size", "FLIP", "p99", "luminance", "rel. MSE", "one frame", "rival, frame", "rival, still",
        "fine", "luminance", "reference", "valid",
    )  # fmt: skip
    return table(head, map(_quality_row, rows))


def _quality_row(r: dict[str, Any]) -> Sequence[Any]:
    rivals = [r["rival"].get(name) for name in ("frame", "still")]
    told = [f"{x['flip_mean']:.3f} ({x['spp']} spp)" if x else "-" for x in rivals]
    better = rivals[0] is not None and r["frame_flip_mean"] < rivals[0]["flip_mean"]
    one = f"**{r['frame_flip_mean']:.3f}**" if better else f"{r['frame_flip_mean']:.3f}"
    fine = r["configurations"].get("fine")  # not in what was measured before 2026-11-26
    told += [f"{fine['flip_mean']:.3f}", f"{100 * fine['luminance_error']:+.1f} %"] if fine else ["-", "-"]
    return (
        r["name"], r["materials"], "×".join(map(str, r["size"])), f"{r['flip_mean']:.3f}", f"{r['flip_p99']:.2f}",
        f"{100 * r['luminance_error']:+.1f} %", f"{r['rel_mse']:.4f}", one, *told,
        f"{r['reference_spp']:,} from the {r['reference_start']}, {r['reference_flip']:.3f}",
        f"yes, for {r['target']:g}" if r["valid"] else f"**no**, for {r['target']:g}",
    )  # fmt: skip


def by_configuration(figure: str, show: Callable[[float], str]) -> Callable[[Rows], str]:
    """A configuration a row, a scene a column."""

    def write(rows: Rows) -> str:
        names = list(rows[0]["configurations"])
        cells = [[show(r["configurations"][name][figure]) for r in rows] for name in names]
        return table(("", *(r["name"] for r in rows)), ([n, *c] for n, c in zip(names, cells, strict=True)))

    return write


def wins(rows: Rows) -> str:
    """FLIP of every configuration, bold where the default is beaten by more than 0.001, and how often it is."""
    names = list(rows[0]["configurations"])
    base = [r["configurations"][names[0]]["flip_mean"] for r in rows]
    lines = []
    for name in names:
        found = [r["configurations"][name]["flip_mean"] for r in rows]
        better = [f < b - 0.001 for f, b in zip(found, base, strict=True)]
        worse = [f > b + 0.001 for f, b in zip(found, base, strict=True)]
        cells = [f"**{f:.3f}**" if b else f"{f:.3f}" for f, b in zip(found, better, strict=True)]
        lines.append([name, *cells, f"{sum(better)} : {sum(worse)}"])
    return table(("changed", *(r["name"] for r in rows), "better : worse"), lines)


def ablation(rows: Rows) -> str:
    """The weights one by one."""
    found = rows[0]["configurations"]
    head = ("weights", "FLIP", "luminance", "MFF mean", "rel. MSE", "leak")
    return table(
        head,
        (
            (n, f"{c['flip_mean']:.3f}", f"{100 * c['luminance_error']:+.0f} %", f"{c['mff_mean']:.4f}", f"{c['rel_mse']:.4f}", f"{100 * c['leak']['mean']:.2f} %")
            for n, c in found.items()
        ),
    )  # fmt: skip


def maps(rows: Rows) -> str:
    """Map sizes: MFF's error and memory."""
    names = list(rows[0]["configurations"])
    head = ["irradiance × distance texels", "kB"]
    for r in rows:
        head += [f"{r['name']}: MFF mean", "MFF max", "FLIP"]
    lines = []
    for name in names:
        cells = [name.replace("x", "² × ") + "²", f"{1e3 * rows[0]['configurations'][name]['field_mb']:,.0f}"]
        for r in rows:
            c = r["configurations"][name]
            cells += [f"{c['mff_mean']:.4f}", f"{c['mff_max']:.2f}", f"{c['flip_mean']:.4f}"]
        lines.append(cells)
    return table(head, lines)


def grids(rows: Rows) -> str:
    """Grid against map size: FLIP."""
    found = rows[0]["configurations"]
    counts = list(dict.fromkeys(name.split()[0] for name in found))
    sizes = list(dict.fromkeys(name.split()[1] for name in found))
    cell = lambda c, n: f"{found[f'{c} {n}']['flip_mean']:.3f}"  # noqa: E731
    return table(
        ("grid", *(f"{n}² texels" for n in sizes)),
        ((c.replace("x", "×"), *(cell(c, n) for n in sizes)) for c in counts),
    )


def volumes(rows: Rows) -> str:
    """The volume that fits by itself beside the best of a search."""
    head = (
        "scene", "probes", "automatic", "best found", "ratio", "which", "others", "by hand", "bounding box",
        "reference",
    )  # fmt: skip
    return table(head, map(_volume_row, rows))


def _volume_row(r: dict[str, Any]) -> Sequence[Any]:
    flip = lambda name: f"{r['trials'][name]['flip_mean']:.3f}"  # noqa: E731
    return (
        r["name"], "×".join(map(str, r["counts"])), flip("automatic"), flip(r["best"]), f"{r['ratio']:.2f}", r["best"],
        len(r["trials"]) - 1, flip("by hand"), flip("bounding box"), f"{r['reference_flip']:.3f}",
    )  # fmt: skip


def leaks(rows: Rows) -> str:
    """A house a row: mean and largest leak of each configuration."""
    names = [name for name in rows[0] if name not in ("wall", "spacing")]
    cell = lambda x: f"{x['mean']:.1e}, {x['max']:.1e}"  # noqa: E731
    lines = ([f"{r['wall']:g} m", f"{r['spacing']:g} m", *(cell(r[n]) for n in names)] for r in rows)
    return table(("walls", "spacing", *names), lines)


def relocation(rows: Rows) -> str:
    """A way to place probes a row: mean FLIP in every scene, by how much it is above that of the last, leak, dark."""
    names = [name for name in rows[0] if name not in ("name", "noise")]

    def cell(r: dict[str, Any], name: str) -> str:
        found = r[name]
        rest = " / ".join(f"{100 * found[kind]:.1f}" for kind in ("leak", "dark"))
        more = f"; {found['more']:+.3f} ± {found['more_error']:.3f}" if "more" in found else ""
        return f"{found['flip_mean']:.3f}{more} ({rest} %, {100 * found['moved']:.0f} %)"

    lines = [[name, *(cell(r, name) for r in rows)] for name in names]
    lines.append(["FLIP between the reference's halves", *(f"{r['noise']:.3f}" for r in rows)])
    return table(("probes", *(r["name"] for r in rows)), lines)


def mff(rows: Rows) -> str:
    """A configuration a row: MFF's error, its mean and its most, and mean FLIP, in every scene."""
    names = list(rows[0]["configurations"])
    head = ["", *(f"{r['name']}: {figure}" for r in rows for figure in ("mean", "most", "FLIP"))]
    cells = [
        [n, *(f"{r['configurations'][n][f]:.{digits}f}" for r in rows for f, digits in (("mff_mean", 4), ("mff_max", 2), ("flip_mean", 3)))]
        for n in names
    ]  # fmt: skip
    return table(head, cells)


def states_saved(rows: Rows) -> str:
    """A scene a row: updates of all probes beside those of the ones awake, by SCALE's rule and by ours."""
    head = (
        "scene", "probes", "update", "SCALE: awake", "saved", "FLIP", "same maps", "ours: awake", "saved", "FLIP", "same maps",
        "noise", "looks",
    )  # fmt: skip
    lines = []
    for r in rows:
        cells: list[str] = []
        for method in ("scale", "cells"):
            m = r[method]
            apart = [f"{m[x]:.4f}" if x in m else "-" for x in ("flip_mean", "flip_same_maps")]
            cells += [f"{m['awake']:,}", f"{100 * m['saved']:.0f} %", *apart]
        noise = f"{r['noise']:.4f}" if "noise" in r else "-"
        first = [r["scene"], f"{r['probes']:,}", f"{r['off']['update_ms']:.0f} ms"]
        lines.append([*first, *cells, noise, f"{100 * r['look_share']:.1f} %"])
    return table(head, lines)


def states_counts(rows: Rows) -> str:
    """A density of a scene a row: CTU's alive, sleeping and dead, and those awake by SCALE's rule and by ours."""
    head = ("scene", "probes", "CTU: alive", "sleeping", "dead", "SCALE: awake", "ours: awake")
    up = lambda found: sum(n for state, n in found.items() if state not in ("sleeping", "off"))  # noqa: E731
    return table(head, (
        [r["scene"], "×".join(map(str, r["counts"])), f"{up(r['ctu']):,}", f"{r['ctu'].get('sleeping', 0):,}",
         f"{r['ctu'].get('off', 0):,}", f"{up(r['scale']):,}", f"{up(r['cells']):,}"]
        for r in rows
    ))  # fmt: skip


def parts(rows: Rows) -> str:
    """What is left as one part after another is made ideal."""
    names = list(rows[0]["parts"])
    lines = [[n, *(f"{r['parts'][n]['flip_mean']:.4f}" for r in rows)] for n in names]
    lines += [
        [f"(default with {n})", *(f"{r['encodings'][n]['flip_mean']:.4f}" for r in rows)]
        for n in rows[0]["encodings"]
    ]
    lines.append(["FLIP between the reference's halves", *(f"{r['reference_flip']:.4f}" for r in rows)])
    return table(("made ideal, one after another", *(r["name"] for r in rows)), lines)


def materials(rows: Rows) -> str:
    """A run a row."""
    head = ("run", "40 textured materials", "one plain", "materials' share")
    lines = [
        (n, f"{r['textured_ms']:.0f} ms", f"{r['plain_ms']:.0f} ms", f"{100 * r['share']:.1f} %")
        for n, r in enumerate(rows, 1)
    ]
    return table(head, lines)


def figures(names: dict[str, str]) -> Callable[[Rows], str]:
    """One row of numbers under these heads."""
    return lambda rows: table(tuple(names.values()), ([r[key] for key in names] for r in rows))


TABLES: dict[str, tuple[str, Callable[[Rows], str]]] = {
    "quality": ("quality", quality),
    "presets": ("presets", by_configuration("flip_mean", "{:.3f}".format)),
    "presets-luminance": ("presets", by_configuration("luminance_error", lambda x: f"{100 * x:+.1f} %")),
    "ablation": ("ablation", ablation),
    "maps": ("maps", maps),
    "grids": ("grids", grids),
    "constants": ("constants", wins),
    "volumes": ("volumes", volumes),
    "leaks": ("leaks", leaks),
    "relocation": ("relocation", relocation),
    "dead": ("dead", mff),
    "rejection": ("rejection", mff),
    "states": ("states", states_saved),
    "states-counts": ("states-counts", states_counts),
    "parts": ("parts", parts),
    "materials": ("materials", materials),
    "fuzz": (
        "fuzz",
        figures(
            {
                "files": "files",
                "loaded": "loaded",
                "refused": "refused",
                "failed": "anything else",
                "seconds": "slowest [s]",
                "megabytes": "most memory [MB]",
            }
        ),
    ),
    "invalid": (
        "invalid",
        figures(
            {
                "files": "files",
                "with_mistakes": "with errors in their report",
                "refused": "of these refused",
                "wrong": "loaded with meaningless content, or failed",
                "seconds": "slowest [s]",
                "megabytes": "most memory [MB]",
            }
        ),
    ),
}
"""Tables by name: the study they come from, and how they are written."""


def written(name: str) -> str:
    """A table, with where it was measured beneath."""
    if name not in TABLES:
        raise SystemExit(f"results.template.md asks for {name!r}; there are {', '.join(TABLES)}")
    study, write = TABLES[name]
    found = load(study)
    if found is None:
        return f"Not measured yet: no docs/results/{study}.json."
    m = found["machine"]
    return (
        f"{write(found['rows'])}\n\n<sub>`{study}.json`: commit {m['commit']}, {m['processor']}, "
        f"Mitsuba {m['mitsuba']}, Dr.Jit {m['drjit']}, Python {m['python']}.</sub>"
    )


def main() -> None:
    """Write the page."""
    text = (DOCS / "results.template.md").read_text()
    page = re.sub(r"^\{\{([\w-]+)\}\}$", lambda m: written(m[1]), text, flags=re.MULTILINE)
    (DOCS / "results.md").write_text(page)


if __name__ == "__main__":
    main()
