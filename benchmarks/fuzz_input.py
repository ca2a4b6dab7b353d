"""Scene files and FOLD files that have been tampered with: refused in words or run, never a traceback, never a hang.

    python benchmarks/fuzz_input.py [--inputs 2000] [--seed 1] [--show refused]

Takes bundled scenes and crease patterns, changes values, keys and structure (and, one time in four, bytes), and gives
each to `warp-origami run` in this process, which is stopped after two steps. Exit code 2 is to leave nothing behind
but one line for each fault that says where, what was found and what is wanted; 0, 3 and 130 a folder with a summary.
Nothing outside that folder may change, no input may take more than LIMIT seconds of processor time or MEMORY bytes
(sheets of some 100 000 elements, which are allowed, would: there are none).
Prints the counts by kind of outcome, and every input that is otherwise; exit code 1 if there is one.
"""

import argparse
import copy
import json
import math
import random
import resource
import shutil
import signal
import sys
import tempfile
import tomllib
import traceback
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from unittest import mock

import tomli_w
from click.testing import CliRunner
from warp_origami.scenes import bundled_scenes

from warp_origami.cli import main as command

LIMIT, MEMORY = 60.0, 8 << 30
SCENES = (
    "single_fold",
    "leaf_in",
    "sagging_sheet",
    "two_sheets",
    "verification/drum",
    "verification/twisted_annulus",
    "hard/miura",
    "ikaros",
    "leaf_out",
    "square_twist",
    "cross_fold",
    "z_fold",
    "hard/strip_folded_twice",
)
FOLDS = ("two_sheets", "hard/strip_folded_twice", "hard/crossing_strips", "verification/patch")

NASTY = [
    *(0, 1, 2, 3, -1, 10**9, 10**18, 10**30, 2**63, 0.0, -0.0, 1e-300, 1e300, -1e300, 1e30, 1e-30, 0.5, 1.0),
    *(math.inf, -math.inf, math.nan, True, False, "", "x", "../x", "/tmp/x", "a/b", "a\x00b", "auto", "é" * 200),
    *([], [0], [[0.0, 0.0]], [1, 2, 3], [[[[[[[[0]]]]]]]], {}, {"kind": "table"}, {"all": True}, {"near": [0, 0]}),
    *([0.0, 0.0, 0.0], [1e300, 1e300], [math.nan, 0.0], "xyz", "dynamic", "static", "modal", "fold", "deployed"),
]
FOLD_NASTY = [*NASTY, None, 1e9, 1e308, "B", "M", "V", "C", "F", "foldedForm", "creasePattern", [0, 0, 0], [0, 1, 1e9]]


def _containers(value: object) -> Iterator[dict | list]:
    """All tables and arrays within a value."""
    if isinstance(value, dict | list):
        yield value
        for item in value.values() if isinstance(value, dict) else value:
            yield from _containers(item)


def mutate(root: dict, chance: random.Random, nasty: list) -> None:
    """One change of structure or value, somewhere."""
    place = chance.choice([one for one in _containers(root) if one] or [root])
    keys = list(place) if isinstance(place, dict) else list(range(len(place)))
    if not keys:
        return
    key, kind = chance.choice(keys), chance.randrange(9)
    value, nasty = place[key], copy.deepcopy(nasty)
    if kind <= 2:
        place[key] = chance.choice(nasty)
    elif kind == 3:
        del place[key]
    elif kind == 4 and isinstance(place, dict):
        place[chance.choice(["x", "kind", "name", "at", "file", key + "_"])] = chance.choice([value, *nasty])
    elif kind == 4:
        place.insert(key, value)
    elif kind == 5:
        other = chance.choice(keys)
        place[key], place[other] = place[other], place[key]
    elif kind == 6 and isinstance(value, int | float) and not isinstance(value, bool):
        place[key] = value * chance.choice([-1, 0.5, 2, 10.0 ** chance.randint(-12, 12)])
    elif kind == 7:
        place[key] = [copy.deepcopy(value)] * chance.choice([1, 2, 3])
    elif isinstance(value, list) and value:
        value[chance.randrange(len(value))] = chance.choice(nasty)


def _stretch(root: dict, chance: random.Random) -> None:
    """One number changed for another of its kind, which may well be allowed."""
    numbers = [
        (place, key)
        for place in _containers(root)
        for key in (place if isinstance(place, dict) else range(len(place)))
        if type(place[key]) in (int, float)
    ]
    place, key = chance.choice(numbers)
    if type(place[key]) is int:
        place[key] = chance.choice([0, 1, 2, 3, 5, 40, 10**6, 10**7, 10**9])
    else:
        place[key] *= chance.choice([0.0, -1.0, 1.01, 0.5, 2.0, 10.0 ** chance.randint(-25, 25)])


def _change(root: dict, chance: random.Random, nasty: list) -> None:
    """One to four changes, of numbers alone in every second case."""
    numbers = chance.random() < 0.5
    for _ in range(chance.choice([1, 1, 2, 4])):
        if numbers:
            _stretch(root, chance)
        else:
            mutate(root, chance, nasty)


def _tampered(content: bytes, chance: random.Random) -> bytes:
    """Some bytes changed, left out, repeated or put in."""
    changed = bytearray(content)
    for _ in range(chance.choice([1, 1, 2, 5])):
        at, kind = chance.randrange(len(changed) + 1), chance.randrange(5)
        piece = changed[at : at + chance.choice([1, 3, 30])]
        if kind == 0:
            changed[at : at + 1] = bytes([chance.randrange(256)])
        elif kind == 1:
            del changed[at : at + len(piece)]
        elif kind == 2:
            changed[at:at] = piece * chance.choice([1, 2, 100])
        elif kind == 3:
            changed[at:at] = chance.choice([b"[", b"{", b'"', b"\x00", b"\xff", b"=", b"\n", b"9" * 30, b"[" * 3000])
        else:
            del changed[at:]
    return bytes(changed)


def _scene(name: str) -> dict:
    path, _ = bundled_scenes()[name]
    tables = tomllib.loads(path.read_text(encoding="utf-8"))
    if "file" in tables["pattern"]:
        tables["pattern"]["file"] = str(path.parent / tables["pattern"]["file"])
    return tables


def write_input(folder: Path, chance: random.Random) -> Path:
    """Writes a scene file that has been tampered with, or whose FOLD file has been, into a folder."""
    path, by_bytes = folder / "scene.toml", chance.random() < 0.25
    if chance.random() < 0.4:
        fold = json.loads(Path(_scene(chance.choice(FOLDS))["pattern"]["file"]).read_text(encoding="utf-8"))
        if not by_bytes:
            _change(fold, chance, FOLD_NASTY)
        content = json.dumps(fold).encode()
        (folder / "pattern.fold").write_bytes(_tampered(content, chance) if by_bytes else content)
        tables = _scene("single_fold")
        tables |= {"pattern": {"kind": "fold", "file": "pattern.fold"}, "support": [], "driver": [], "probe": []}
        tables |= {"contact": {}} if chance.random() < 0.5 else {}
        path.write_text(tomli_w.dumps(tables), encoding="utf-8")
        return path
    tables = _scene(chance.choice(SCENES))
    if chance.random() < 0.8:  # half of some files, and without effect on a run
        tables.pop("verification", None)
    if not by_bytes:
        _change(tables, chance, NASTY)
    content = tomli_w.dumps(tables).encode("utf-8", "surrogatepass")
    path.write_bytes(_tampered(content, chance) if by_bytes else content)
    return path


class Hung(BaseException):
    """An input that takes too long."""


@contextmanager
def limited(seconds: float) -> Iterator[None]:
    """Raises Hung in the block after so much processor time."""

    def ring(*_: object) -> None:
        raise Hung

    before = signal.signal(signal.SIGVTALRM, ring)
    signal.setitimer(signal.ITIMER_VIRTUAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
        signal.signal(signal.SIGVTALRM, before)


def two_steps(run, state, interrupted) -> dict:
    """In place of the loop of a run: its first two steps."""
    failure = None
    for _ in range(2):
        if failure is None and not run.at_end(state):
            state, failure = run.advance(state)
    return run.finish(state, "interrupted" if failure is None else "failed", failure)


def tried(folder: Path, path: Path) -> tuple[str, str]:
    """Kind of outcome of an input in a folder, and what is wrong with it, or was said."""
    before = _contents(folder)
    try:
        with limited(LIMIT), mock.patch("warp_origami.solve.simulate.loop", two_steps):
            ended = CliRunner().invoke(command, ["run", str(path), "--out", str(folder / "out"), "--quiet"])
    except Hung:
        return "HANG", ""
    code, said = ended.exit_code, ended.stderr
    if isinstance(ended.exception, Hung):
        return "HANG", ""
    if ended.exception is not None and not isinstance(ended.exception, SystemExit):
        return "TRACEBACK", "".join(traceback.format_exception(ended.exception)[-3:])
    if "Traceback" in said or "Error:" in said:
        return "TRACEBACK", said
    after = {name: content for name, content in _contents(folder).items() if not name.startswith("out/")}
    if after != before:
        return "WRITES OUTSIDE", f"{sorted(after)}"
    if code == 2:
        told = all(": got " in line and ", wants " in line for line in said.splitlines())
        if not said or not told:
            return "MESSAGE", said
        return ("PARTIAL FOLDER", said) if (folder / "out").exists() else ("refused", said)
    if not (folder / "out" / "summary.json").exists():
        return "NO SUMMARY", f"{code} {said}"
    return {0: "run", 130: "run", 3: "numerics failed"}.get(code, f"EXIT {code}"), said


def _contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def main() -> int:
    """Tries so many inputs; exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--inputs", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--show", default="")
    given = parser.parse_args()
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    counts: Counter[str] = Counter()
    for number in range(given.first, given.first + given.inputs):
        with tempfile.TemporaryDirectory() as place:
            path = write_input(Path(place), random.Random(f"{given.seed} {number}"))
            kind, said = tried(Path(place), path)
            counts[kind] += 1
            if kind.isupper() or kind == given.show:
                print(f"--- input {number}: {kind}\n{said}", flush=True)
                if kind.isupper():
                    shutil.copytree(
                        place, Path(tempfile.gettempdir()) / f"fuzz_{given.seed}_{number}", dirs_exist_ok=True
                    )
    print(f"seed {given.seed}, {given.inputs} inputs: " + ", ".join(f"{n} {kind}" for kind, n in counts.most_common()))
    return 1 if any(kind.isupper() for kind in counts) else 0


if __name__ == "__main__":
    sys.exit(main())
