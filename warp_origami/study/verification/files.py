"""What a verification leaves in a folder: a table of all results as CSV and JSON, and a plot of errors per case."""

import csv
import dataclasses
import io
import json
import math
from collections.abc import Sequence
from pathlib import Path, PurePosixPath

import matplotlib

from warp_origami.output.files import write_text

from .convergence import ROUND_OFF, Convergence

matplotlib.use("agg")
import matplotlib.pyplot as plt  # after the choice of a backend that needs no display

COLUMNS = (
    "scene",
    "value",
    "mesh",
    "elements",
    "steps",
    "expected",
    "obtained",
    "error",
    "tolerance",
    "within",
    "order",
    "extrapolated",
    "seconds",
)


def write_results(folder: Path, found: Sequence[Convergence]) -> None:
    """Writes verification.csv and verification.json into the folder."""
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    writer.writeheader()
    for case in found:
        writer.writerows(_rows(case))
    write_text(folder / "verification.csv", text.getvalue())
    content = [dataclasses.asdict(case) | {"passed": case.passed, "rows": _rows(case)} for case in found]
    write_text(folder / "verification.json", json.dumps(_finite(content), indent=1) + "\n")


def _rows(case: Convergence) -> list[dict]:
    rows = []
    for k, claim in enumerate(case.claims):
        errors = case.errors(k)
        for i, level in enumerate(case.levels):
            last = i == len(case.levels) - 1
            rows.append(
                {
                    "scene": case.name,
                    "value": claim.name,
                    "mesh": level.label,
                    "elements": level.elements,
                    "steps": level.steps,
                    "expected": claim.exact,
                    "obtained": level.obtained[k],
                    "error": errors[i],
                    "tolerance": claim.tolerances[i],
                    "within": case.holds(k, i),
                    "order": case.order(k) if last else None,
                    "extrapolated": case.extrapolated(k) if last else None,
                    "seconds": round(level.seconds, 2),
                }
            )
    return rows


def _finite(value: object) -> object:
    """The same with null for numbers that JSON does not have."""
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def draw(case: Convergence, path: Path) -> None:
    """Plots the errors of a case over the fineness of its meshes (or steps), as PNG."""
    fineness = case.fineness()
    by_steps = len({level.elements for level in case.levels}) == 1
    figure, axes = plt.subplots(figsize=(8.4, 4.0), layout="constrained")
    for k, claim in enumerate(case.claims):
        errors = [max(abs(error), ROUND_OFF / 1e4) for error in case.errors(k)]
        order = case.order(k)
        label = claim.name if order is None else f"{claim.name} (order {order:z.1f})"
        (line,) = axes.loglog(fineness, errors, "o-", label=label)
        if claim.tolerances[len(case.levels) - 1] is not None:
            axes.plot(fineness[-1], claim.tolerances[len(case.levels) - 1], "_", color=line.get_color(), ms=14)
    axes.set_xlabel("time steps" if by_steps else "square root of the number of elements")
    axes.set_ylabel("relative error (absolute where 0 is exact)")
    axes.set_title(f"{PurePosixPath(case.name).stem}: bars are tolerances on the finest")
    axes.set_xticks(fineness, [f"{n:.0f}" for n in fineness])
    axes.minorticks_off()
    axes.grid(alpha=0.3)
    figure.legend(loc="outside right upper", fontsize="small")
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)
    plt.close(figure)
