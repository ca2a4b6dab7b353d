"""The numbers of a run of a study, read from its files."""

import csv
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from warp_origami.solve.records import PROBE_COLUMNS, REACTION_COLUMNS

from ..results import read_value
from .document import SUMMARY_COLUMNS, Study


@dataclass(frozen=True, eq=False)
class Files:
    """The tables of a run in the form in which results are read from runs in memory; see api.Run."""

    history: dict[str, np.ndarray]
    probes: dict[str, np.ndarray]
    reactions: dict[str, np.ndarray]
    spin: dict[str, np.ndarray]
    summary: dict


def read_files(folder: Path) -> Files:
    """The tables and the summary of a run.

    Raises:
        OSError, ValueError: they cannot be read.
    """
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    history = _columns(folder / "history.csv")
    probes = _grouped(_columns(folder / "probes.csv"), PROBE_COLUMNS)
    reactions = _grouped(_columns(folder / "reactions.csv"), REACTION_COLUMNS)
    spin = _columns(folder / "spin.csv") if (folder / "spin.csv").exists() else {}
    return Files(history, probes, reactions, spin, summary)


def _columns(path: Path) -> dict[str, np.ndarray]:
    with path.open(newline="", encoding="utf-8") as file:
        heading, *rows = csv.reader(file)
    table = np.array(rows, dtype=float).reshape(len(rows), len(heading))
    return dict(zip(heading, table.T, strict=True))


def _grouped(columns: dict[str, np.ndarray], names: tuple[str, ...]) -> dict[str, np.ndarray]:
    """NAME.column -> (n,) as NAME -> (n, columns)."""
    owners = dict.fromkeys(heading.rpartition(".")[0] for heading in columns if heading != "time")
    return {owner: np.column_stack([columns[f"{owner}.{name}"] for name in names]) for owner in owners}


def numbers(study: Study, folder: Path) -> dict[str, float | None]:
    """Results of the study and numbers of the summary, None where a run has none; frequencies in Hz.

    Empty where nothing can be read.
    """
    try:
        files = read_files(folder)
    except (OSError, ValueError):
        return {}
    found: dict[str, float | None] = {}
    for result in study.result:
        try:
            value = read_value(result.of, files)
        except KeyError:  # a run that has not come to its frequencies
            value = np.nan
        found[result.name] = value if np.isfinite(value) else None
    found |= {f"frequencies.{k}": value for k, value in enumerate(files.summary.get("frequencies", ()))}
    return found | {name: files.summary.get(name) for name in SUMMARY_COLUMNS}
