"""The paper's section 5, statement by statement: its three models run, tabulated and drawn.

    python benchmarks/paper.py [--out runs/paper] [--models-only]

Runs the leaf-in square without contact (Model 1), with surface-to-surface contact (2) and with mixed contact (3), and
variations of what the paper leaves open. Runs are kept in --out; what is complete there is not run again. Writes to
results/ paper.csv (every statement of the section beside our value), paper_crossings.csv (which runs cross, when, where
and how deep) and our versions of figures 11 to 16. docs/paper.md says what they mean. Needs the extra `test`.
"""

import argparse
import csv
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import warp as wp
from paper.figures import draw_all
from paper.places import crease_name, face_name
from paper.runs import MODELS, VARIATIONS, Case, Result, simulate
from paper.section_5_1 import EARLY, comparison, model
from paper.section_5_2 import configurations, energies, stresses, vibrations
from paper.statement import Statement
from paper.watch import Watched, crossing_states

RESULTS = Path(__file__).parent / "results"
DRAWN, FINE, FINEST = 4, 8, 16
"""Sub-triangles along an element's side: of the sub-mesh that is drawn and that carries contact, and of finer ones."""


def main() -> None:
    """Runs what is missing, writes tables and figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("runs/paper"), help="folder of the runs")
    parser.add_argument("--models-only", action="store_true", help="without the variations")
    options = parser.parse_args()
    wp.config.quiet = True
    cases = MODELS if options.models_only else (*MODELS, *VARIATIONS)
    for case in cases:
        simulate(case, options.out, lambda text: print(text, flush=True))

    results = [Result(case, options.out) for case in MODELS]
    watched = [Watched(result, options.out, FINE) for result in results]
    _write("paper.csv", _rows(_statements(results, watched)))
    _write(
        "paper_crossings.csv",
        [_CROSSING_COLUMNS, *(_crossing_row(case, options.out) for case in cases if not case.drive)],
    )
    draw_all(results, watched, RESULTS)


def _statements(results: Sequence[Result], watched: Sequence[Watched]) -> list[Statement]:
    """All statements in the order of the section."""
    return [
        *model(results),
        *comparison(results, watched),
        *configurations(results, watched),
        *energies(results, watched),
        *stresses(results, watched),
        *vibrations(results),
    ]


def _rows(statements: Sequence[Statement]) -> list[Sequence[str]]:
    return [
        ("number", "where", "paper", "ours", "agrees"),
        *((str(k), s.where, s.paper, s.ours, s.agrees) for k, s in enumerate(statements, 1)),
    ]


_CROSSING_COLUMNS = (
    "run",
    "states",
    f"cross, {DRAWN} a side",
    f"cross, {FINE} a side",
    f"cross, {FINEST} a side",
    "first, s",
    "last, s",
    f"deepest, mm (before {EARLY} s if it crosses then)",
    "where",
    "penetration / thickness",
)


def _crossing_row(case: Case, folder: Path) -> list[str]:
    """What is seen of one run; when, where and how deep on FINE if it crosses there, else on DRAWN."""
    result = Result(case, folder)
    drawn, fine = (Watched(result, folder, divisions) for divisions in (DRAWN, FINE))
    mesh, thickness = result.system.mesh, result.system.scene.material.thickness
    seen = fine if fine.crosses.any() else drawn
    times = seen.times[seen.crosses]
    early = seen.crosses & (seen.times < EARLY)
    depths = np.where(early if early.any() else seen.crosses, seen.depths, -1.0)
    where = ""
    if seen.crosses.any():
        found = seen.crossings[int(np.argmax(depths))][0]
        where = f"{crease_name(mesh, found.flat) or face_name(mesh, found.face)} beyond {face_name(mesh, found.beyond)}"
    return [
        case.label,
        str(len(result.times)),
        str(int(drawn.crosses.sum())),
        str(int(fine.crosses.sum())),
        str(int(crossing_states(result, folder, FINEST).sum())),
        f"{times[0]:.3f}" if len(times) else "",
        f"{times[-1]:.3f}" if len(times) else "",
        f"{1e3 * depths.max():.3f}" if len(times) else "",
        where,
        f"{fine.penetration.max() / thickness:.4f}",
    ]


def _write(name: str, rows: Sequence[Sequence[str]]) -> None:
    """Writes a table to results/ and prints it for a page of text."""
    RESULTS.mkdir(exist_ok=True)
    with open(RESULTS / name, "w", newline="") as file:
        csv.writer(file).writerows(rows)
    header, *body = rows
    for row in (header, ["---"] * len(header), *body):
        print(f"| {' | '.join(row)} |")
    print(flush=True)


if __name__ == "__main__":
    main()
