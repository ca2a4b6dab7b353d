"""report.html: the page of a run, made from the files of the run alone.

Everything that can be read without a script is in the HTML; the script of the page draws the animation and the plots.
The page asks the browser to refuse every connection (Content-Security-Policy), so that it is what it was, anywhere.
"""

import html
import json
import math
import re
from datetime import UTC, datetime
from functools import cache
from pathlib import Path

import numpy as np

from warp_origami.errors import InputError
from warp_origami.output.files import write_text

from .charts import as_dictionaries, charts, thinned
from .coding import Blob
from .drawn_sheet import DrawnSheet, draw_sheet
from .run_files import RunFiles, read_run_files
from .tables import (
    energy_put_in,
    machine_rows,
    model_rows,
    pairs_html,
    phases_html,
    result_rows,
    settings,
    settings_html,
)

NAME = "report.html"
ASSETS = Path(__file__).parent / "assets"
LIBRARIES = {"vendor/three.LICENSE": "vendor/three.bundle.min.js", "vendor/uPlot.LICENSE": "vendor/uPlot.iife.min.js"}
STYLES = ("vendor/uPlot.min.css", "page.css")
SCRIPTS = ("data.js", "format.js", "colours.js", "sheet.js", "stage.js", "player.js", "plots.js", "main.js")

FIELDS = {
    "von_mises": ("von Mises stress", "Pa"),
    "s1": ("principal stress S1", "Pa"),
    "s2": ("principal stress S2", "Pa"),
    "state": ("wrinkle state", ""),
    "contact_pressure": ("contact pressure", "Pa"),
}
ENERGY_LOST = (
    "Energy lost: to the algorithmic damping of the time integration (integrator.spectral_radius), which takes out "
    "vibrations that the steps do not resolve. It adds up over the run, so it may exceed the largest energy that there "
    "is at one time; of the energy put in (at the start, and as work of loads and drivers) it is at most 100 %."
)
STATUS = {
    "done": "done",
    "failed": "failed",
    "interrupted": "interrupted",
    "": "no summary: killed, or still running",
}


def build_report(folder: Path, out: Path | None = None) -> tuple[Path, tuple[str, ...]]:
    """Writes the page of the run in `folder`, whatever is left of it.

    Args:
        folder: of the run.
        out: file to write; None: report.html in the folder.

    Returns:
        The file, and remarks on what is missing or left out, which the page shows too.

    Raises:
        InputError: there is no run.
        OSError: the page cannot be written.
    """
    files = read_run_files(folder)
    remarks = list(files.remarks)
    sheet = _sheet(files, remarks)
    text = _filled((ASSETS / "page.html").read_text(encoding="utf-8"), _parts(files, sheet, remarks))
    path = folder / NAME if out is None else out
    write_text(path, text)
    return path, tuple(remarks)


def _sheet(files: RunFiles, remarks: list[str]) -> DrawnSheet | None:
    if files.animation is None:
        return None
    try:
        sheet = draw_sheet(files.animation)
    except InputError as error:
        remarks.append(f"animation.usdc cannot be drawn: {error.got}.")
        return None
    if sheet.stride > 1:
        left_out = f"{sheet.frames} of {sheet.in_file} frames are in this page, every {sheet.stride}th"
        remarks.append(f"{left_out}, to keep it small; animation.usdc has them all.")
    if not files.animation.creases.size and _has_creases(files):
        remarks.append("animation.usdc was written by an earlier version: creases are not drawn.")
    return sheet


def _has_creases(files: RunFiles) -> bool:
    kind = files.settings.get("pattern", {}).get("kind", "sheet")
    return kind not in ("sheet", "disc", "annulus")


def _parts(files: RunFiles, sheet: DrawnSheet | None, remarks: list[str]) -> dict[str, str]:
    """What the places of the template are filled with."""
    tables, blob = {}, Blob()
    for name, table in files.tables.items():
        short = thinned(table)
        if len(short) < len(table):
            kept = f"of the {len(table)} rows of {name}.csv, {len(short)} are plotted"
            remarks.append(f"{kept[0].upper()}{kept[1:]}: no peak is lost, and the file has them all.")
        tables[name] = {"columns": short.columns, "rows": len(short)}
        blob.add(f"{name} time", short.values[:, 0].astype(np.float64))
        with np.errstate(over="ignore"):
            blob.add(name, short.values[:, 1:].T.astype(np.float32))
    described = {
        "name": files.name,
        "kind": files.kind,
        "done": _status(files) == "done",
        "end": _number(files.analysis.get("duration"), 1.0),
        "tables": tables,
        "charts": as_dictionaries(charts(files)),
        "sheet": None if sheet is None else _described(sheet),
        "frequencies": files.summary.get("frequencies") or [],
        "arrays": blob.index + ([] if sheet is None else sheet.blob.index),
    }
    texts = blob.text() + ([] if sheet is None else sheet.blob.text())
    return {
        "name": html.escape(files.name),
        "style": "\n".join(_asset(name) for name in STYLES),
        "lead": html.escape(_lead(files)),
        "status": html.escape(STATUS.get(_status(files), _status(files))),
        "status_class": _status(files) if _status(files) in STATUS else "",
        "message": _message(files.summary),
        "remarks": "".join(f"<li>{html.escape(remark)}</li>" for remark in remarks),
        "no_remarks": "" if remarks else "hidden",
        "summary": _results(files),
        "phases": phases_html(files.summary),
        "settings": settings_html(settings(files)),
        "model": pairs_html(model_rows(files.summary)),
        "machine": pairs_html(machine_rows(files)) if machine_rows(files) else "<p>Not told by the run's files.</p>",
        "libraries": "\n".join(
            f"<script>/*\n{_asset(licence)}*/\n{_asset(name)}</script>" for licence, name in LIBRARIES.items()
        ),
        "run": _json(described),
        "arrays": "\n".join(f'<script type="text/plain" class="array">{text}</script>' for text in texts),
        "script": "\n".join(_asset(name) for name in SCRIPTS),
    }


def _described(sheet: DrawnSheet) -> dict:
    fields = []
    for name, found in sheet.ranges.items():
        label, unit = FIELDS.get(name, (name, ""))
        fields.append({"name": name, "label": label, "unit": unit} | vars(found))
    return {"frames": sheet.frames, "origin": sheet.origin.tolist(), "step": sheet.step, "fields": fields}


def _results(files: RunFiles) -> str:
    """The numbers of the run, and what they mean where that is not plain."""
    if not files.summary:
        return "<p>summary.json is missing.</p>"
    if files.kind != "dynamic" or "energy_loss" not in files.summary:
        return pairs_html(result_rows(files.summary))
    rows = pairs_html(result_rows(files.summary, energy_put_in(files.tables.get("history"))))
    return f'{rows}<p class="hint">{html.escape(ENERGY_LOST)}</p>'


def _status(files: RunFiles) -> str:
    return str(files.summary.get("status", ""))


def _lead(files: RunFiles) -> str:
    """One line on the run."""
    reached = files.tables["history"].values[-1:, 0] if "history" in files.tables else np.empty(0)
    parts = {"dynamic": "motion in time", "static": "equilibrium", "modal": "free vibrations"}[files.kind]
    told = [parts[0].upper() + parts[1:]]
    end = _number(files.analysis.get("duration"), 0.0) if files.kind == "dynamic" else 1.0
    if len(reached) and _status(files) == "done" and files.kind != "modal" and reached[0] < (1.0 - 1e-9) * end:
        of = f"{reached[0]:.6g} of {end:g}"
        told.append(f"{of} s (--until)" if files.kind == "dynamic" else f"load factor {of} (--until)")
    elif end and files.kind == "dynamic":
        told.append(f"{end:g} s")
    if len(reached) and _status(files) != "done":
        what = "s" if files.kind == "dynamic" else "of the load"
        told.append(f"reached {reached[0]:.6g} {what}")
    if "elements" in files.summary:
        told.append(f"{files.summary['elements']} elements")
    written = max((path.stat().st_mtime for path in files.folder.iterdir() if path.name != NAME), default=0.0)
    told.append(f"files of {datetime.fromtimestamp(written, UTC):%Y-%m-%d %H:%M} UTC")
    return " · ".join(told)


def _message(summary: dict) -> str:
    """Message and advice of the run, if it has any."""
    parts = [("message", "Message"), ("advice", "Advice")]
    told = [(label, str(summary[key])) for key, label in parts if summary.get(key)]
    kind = "failed" if summary.get("status") == "failed" else "told"
    rows = "".join(f"<dt>{label}</dt><dd>{html.escape(text)}</dd>" for label, text in told)
    return f'<section class="message {kind}" role="status"><dl>{rows}</dl></section>' if told else ""


def _number(value: object, otherwise: float) -> float:
    return float(value) if isinstance(value, int | float) and math.isfinite(value) else otherwise


def _json(value: object) -> str:
    """JSON that can stand in a script element; numbers that are not finite as null."""
    return json.dumps(_finite(value)).replace("<", "\\u003c")


def _finite(value: object) -> object:
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


@cache
def _asset(name: str) -> str:
    return (ASSETS / name).read_text(encoding="utf-8")


def _filled(template: str, parts: dict[str, str]) -> str:
    """The template with every {{place}} filled, in one pass: what is filled in is not looked at again."""
    return re.sub(r"\{\{(\w+)\}\}", lambda place: parts[place[1]], template)
