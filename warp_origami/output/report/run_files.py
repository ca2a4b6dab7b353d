"""What is left of a run: each of its files, if it is there and as far as it can be read."""

import json
import tomllib
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from warp_origami.errors import InputError
from warp_origami.output.animation_file import AnimationFile
from warp_origami.scene import Scene, load_scene

TABLES = ("history", "probes", "reactions")
"""Of every run."""

SPIN = "spin"
"""Table of runs that spin."""


@dataclass(frozen=True)
class Table:
    """Rows of numbers.

    Attributes:
        columns: headings; the first is time.
        values: (n, number of columns).
    """

    columns: tuple[str, ...]
    values: np.ndarray

    def __len__(self) -> int:
        return len(self.values)


@dataclass(frozen=True)
class RunFiles:
    """The files of a run.

    Attributes:
        folder: where they are.
        scene: as validated; None if the file is missing or this version does not accept it.
        settings: the scene file as tables; empty if it cannot be read.
        summary: content of summary.json; empty without it.
        tables: history, probes, reactions and spin, as far as they are there.
        animation: None if it is missing or damaged.
        remarks: sentences on what is missing, damaged or left out.
    """

    folder: Path
    scene: Scene | None
    settings: dict
    summary: dict
    tables: dict[str, Table]
    animation: AnimationFile | None
    remarks: tuple[str, ...]

    @property
    def name(self) -> str:
        """Of the scene, or else of the folder."""
        return str(self.settings.get("name") or self.summary.get("scene") or self.folder.absolute().name)

    @property
    def analysis(self) -> dict:
        """The table [analysis] of the scene file."""
        found = self.settings.get("analysis")
        return found if isinstance(found, dict) else {}

    @property
    def kind(self) -> str:
        """dynamic, static or modal."""
        kind = self.analysis.get("kind")
        return kind if kind in ("static", "modal") else "dynamic"


@dataclass
class _Reader:
    folder: Path
    remarks: list[str] = field(default_factory=list)

    def settings(self) -> tuple[dict, Scene | None]:
        path = self.folder / "scene.toml"
        try:
            settings = tomllib.loads(path.read_text(encoding="utf-8"))
        except FileNotFoundError:
            self.remarks.append("scene.toml is missing: the settings of the run are not known.")
            return {}, None
        except (OSError, ValueError) as error:
            self.remarks.append(f"scene.toml cannot be read ({error}): the settings of the run are not known.")
            return {}, None
        try:
            return settings, load_scene(path)
        except InputError as error:
            reason = str(error).splitlines()[0]
            self.remarks.append(
                f"scene.toml is shown as it is, without units: this program does not take it ({reason})."
            )
            return settings, None

    def summary(self) -> dict:
        path = self.folder / "summary.json"
        try:
            found = json.loads(path.read_text(encoding="utf-8"))
        except FileNotFoundError:
            self.remarks.append(
                "summary.json is missing: the run was killed or goes on. What it had written until then is shown."
            )
            return {}
        except (OSError, ValueError) as error:
            self.remarks.append(f"summary.json cannot be read ({error}).")
            return {}
        return found if isinstance(found, dict) else {}

    def table(self, name: str) -> Table | None:
        path = self.folder / f"{name}.csv"
        if name == SPIN and not path.exists():
            return None
        try:
            heading, *lines = path.read_text(encoding="utf-8").split("\n")
        except FileNotFoundError:
            self.remarks.append(f"{name}.csv is missing.")
            return None
        except (OSError, ValueError) as error:
            self.remarks.append(f"{name}.csv cannot be read ({error}).")
            return None
        columns = tuple(heading.split(","))
        if columns[0] != "time":
            self.remarks.append(f"{name}.csv cannot be read: its first column is not time.")
            return None
        values, whole = _numbers([line for line in lines[:-1] if line], len(columns))
        if not whole:
            self.remarks.append(f"{name}.csv is damaged after {len(values)} rows; what follows is left out.")
        elif not len(values):
            self.remarks.append(f"{name}.csv holds no rows.")
        return Table(columns, values)

    def animation(self) -> AnimationFile | None:
        path = self.folder / "animation.usdc"
        if not path.exists():
            self.remarks.append("animation.usdc is missing: there is nothing to draw.")
            return None
        try:
            return AnimationFile(path)
        except InputError as error:
            self.remarks.append(f"animation.usdc cannot be drawn: {error.got}.")
            return None


def read_run_files(folder: Path) -> RunFiles:
    """Reads what there is in the folder of a run.

    Raises:
        InputError: none of a run's files is there.
    """
    names = ("scene.toml", "summary.json", "animation.usdc", *(f"{name}.csv" for name in TABLES))
    if not any((folder / name).exists() for name in names):
        raise InputError("DIR", repr(str(folder)), "the folder of a run, with some of " + ", ".join(names))
    reader = _Reader(folder)
    settings, scene = reader.settings()
    summary = reader.summary()
    tables = {name: reader.table(name) for name in (*TABLES, SPIN)}
    found = {name: table for name, table in tables.items() if table is not None}
    animation = reader.animation()
    return RunFiles(folder, scene, settings, summary, found, animation, tuple(reader.remarks))


def _numbers(lines: list[str], width: int) -> tuple[np.ndarray, bool]:
    """Rows of `width` numbers up to the first line that holds none, and whether all did."""
    rows = [line.split(",") for line in lines]
    try:
        return np.array(rows, dtype=float).reshape(len(rows), width), True
    except ValueError:
        pass
    values = []
    for row in rows:
        try:
            numbers = [float(entry) for entry in row]
        except ValueError:
            break
        if len(numbers) != width:
            break
        values.append(numbers)
    return np.array(values).reshape(len(values), width), False
