"""Damaged files against the loaders: each must load, or be refused by a `SceneError` of one line.

    python benchmarks/fuzz_gltf.py               # 20,000 files, into docs/results/fuzz.json
    python benchmarks/fuzz_gltf.py 500 --first 7000
    python benchmarks/fuzz_gltf.py 1 --first 7123 --keep DIRECTORY

The same number gives the same file, while the undamaged ones stay the same. Of twenty files sixteen are
glTF, three OBJ with MTL, one PLY. glTF and OBJ are read up to the description that Mitsuba's parser takes,
whose meshes must be finite and in range; PLY to the scene. A file may take one second
of processor time, and 512 MB beyond what a process has that has read the undamaged ones.
"""

from __future__ import annotations

import json
import random
import re
import sys
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import click

import damage
import fuzz_seeds
from contained import Outcome, outcome, outcomes
from gltf_writing import glb_bytes
from studies import RESULTS, machine

MANY = 20_000
Files = dict[str, bytes]
"""By name; the first is what is loaded."""


def damaged(number: int) -> Files:
    """The damaged files of a number."""
    chance = random.Random(f"ddgi {number}")
    share = number % 20
    if share < 16:
        return _gltf(chance)
    return _obj(chance) if share < 19 else _ply(chance)


def undamaged() -> Iterator[Files]:
    """What they were before."""
    for document, data in _documents()[0]:
        yield {"thing.glb": glb_bytes(damage.text(document), data)}
    yield {"thing.obj": fuzz_seeds.OBJ, "house.mtl": fuzz_seeds.MTL, "wall.png": fuzz_seeds.PICTURE}
    yield from ({"thing.ply": data} for data in fuzz_seeds.ply())


def loaded(files: Files) -> Outcome:
    """What becomes of files in a folder of their own."""
    with TemporaryDirectory() as folder:
        return outcome(written(files, Path(folder)))


def written(files: Files, folder: Path) -> Path:
    """The files in a folder; the path of the first."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, data in files.items():
        (folder / name).write_bytes(data)
    return folder / next(iter(files))


def _gltf(chance: random.Random) -> Files:
    documents, changer = _documents()
    document, data = chance.choice(documents)
    way = chance.random()
    if way < 0.8:
        document = changer.damaged(document, chance)
    if way > 0.65:
        data = damage.bytes_damaged(data, chance)
    if chance.random() < 0.5:
        whole = glb_bytes(damage.text(document), data)
        return {"thing.glb": damage.bytes_damaged(whole, chance) if way > 0.9 else whole}
    buffers = document.get("buffers")
    if isinstance(buffers, list) and buffers and isinstance(buffers[0], dict):
        document = document | {"buffers": [{"uri": "thing.bin"} | buffers[0], *buffers[1:]]}
    text = damage.text(document)
    return {"thing.gltf": damage.bytes_damaged(text, chance) if way > 0.9 else text, "thing.bin": data}


def _obj(chance: random.Random) -> Files:
    parts = [fuzz_seeds.OBJ, fuzz_seeds.MTL, fuzz_seeds.PICTURE]
    worse = chance.choice((0, 0, 0, 1, 1, 2))
    change = chance.choice((damage.words_damaged, damage.words_damaged, damage.bytes_damaged))
    parts[worse] = change(parts[worse], chance)
    return dict(zip(("thing.obj", "house.mtl", "wall.png"), parts, strict=True))


def _ply(chance: random.Random) -> Files:
    data = chance.choice(fuzz_seeds.ply())
    return {"thing.ply": chance.choice((damage.words_damaged, damage.bytes_damaged))(data, chance)}


@cache
def _documents() -> tuple[list[fuzz_seeds.Document], damage.JsonDamage]:
    documents = fuzz_seeds.documents()
    return documents, damage.JsonDamage([document for document, _ in documents])


def _load(number: int) -> Outcome:
    return loaded(damaged(number))


def _warm_up() -> None:
    for files in undamaged():
        found = loaded(files)
        if found.what != "loaded":
            raise SystemExit(f"an undamaged {next(iter(files))} is {found.what}: {found.how}")


def _alike(text: str) -> str:
    """A message without what differs from file to file."""
    text = re.sub(r"/\S+/", "", text)
    text = re.sub(r"\"[^\"]*\"|'[^']*'", "'...'", text)
    return re.sub(r"-?[0-9]+(\.[0-9]+)?(e[+-]?[0-9]+)?", "N", text)[:100]


@click.command()
@click.argument("count", default=MANY)
@click.option("--first", default=0, help="Number of the first file.")
@click.option("--keep", type=click.Path(path_type=Path), help="Write the files here, and load none.")
def main(count: int, first: int, keep: Path | None) -> None:
    """Load many damaged files; exit code 1 if one does neither load nor is refused."""
    numbers = range(first, first + count)
    if keep is not None:
        for number in numbers:
            print(written(damaged(number), keep / str(number)))
        return
    kinds: Counter[tuple[str, str]] = Counter()
    failures = []
    slowest = memory = 0.0
    for number, found in outcomes(_load, numbers, _warm_up):
        kinds[found.what, _alike(found.how)] += 1
        slowest, memory = max(slowest, found.seconds), max(memory, found.megabytes)
        if found.what == "failed":
            failures.append({"file": number, "how": found.how})
            print(f"file {number}: {found.how}", flush=True)
    for (what, how), times in kinds.most_common(60):
        print(f"{times:>6} {what} {how}")
    refused = [times for (what, _), times in kinds.items() if what == "refused"]
    row = {
        "files": count, "loaded": kinds["loaded", ""], "refused": sum(refused),
        "failed": len(failures), "seconds": round(slowest, 2), "megabytes": round(memory),
    }  # fmt: skip
    print(json.dumps(row))
    if numbers == range(MANY):
        text = json.dumps({"machine": machine(), "rows": [row], "failures": failures}, indent=1)
        (RESULTS / "fuzz.json").write_text(text + "\n")
    sys.exit(bool(failures))


if __name__ == "__main__":
    main()
