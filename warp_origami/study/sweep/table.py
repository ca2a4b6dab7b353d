"""sweep.csv: a row for each run of a study."""

import csv
import io
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from warp_origami.output.files import write_text

from .document import SUMMARY_COLUMNS, Study
from .outcome import Outcome
from .plan import Run


@dataclass(frozen=True)
class Row:
    """A run, how it ended, and its numbers by name."""

    run: Run
    outcome: Outcome
    numbers: dict[str, float | None]


def write_table(path: Path, study: Study, rows: Sequence[Row]) -> None:
    """Writes the table: number and folder, parameters, status and message, results, frequencies, summary."""
    keys = [parameter.key for parameter in study.parameter]
    modes = max((sum(name.startswith("frequencies.") for name in row.numbers) for row in rows), default=0)
    results = [result.name for result in study.result] + [f"frequencies.{k}" for k in range(modes)]
    columns = ["run", "folder", *keys, "status", "message", *results, *SUMMARY_COLUMNS]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    for row in rows:
        folder = f"runs/{row.run.digest}" if row.run.digest else ""
        values = [shown(value) for value in row.run.values]
        numbers = [shown(row.numbers.get(name)) for name in (*results, *SUMMARY_COLUMNS)]
        writer.writerow([row.run.number, folder, *values, row.outcome.status, row.outcome.message, *numbers])
    write_text(path, text.getvalue())


def shown(value: Any) -> str:
    """A value of the scene or a number as it stands in the table: text as it is, nothing for None, else as JSON."""
    if value is None:
        return ""
    return value if isinstance(value, str) else json.dumps(value)
