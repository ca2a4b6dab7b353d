"""The reference of the scene file, made from the models that validate it: keys, what they want, units, defaults.

    python docs/scene_reference.py

writes scene_reference.md.
"""

import re
import typing
from pathlib import Path

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from warp_origami.scene import Scene

HEAD = """# Scene file

Every key, what it wants with its unit, and its default, as the program checks them. Units are SI: m, kg, s, N, Pa, rad.
Unknown keys are errors. A key of a table is written under `[table]`, of an array of tables under `[[table]]`;
`--set table.key=value` changes it for one run.
"""


def reference() -> str:
    """The page as Markdown."""
    parts, inner = [HEAD], []
    for name, field in Scene.model_fields.items():
        tables = _tables(field.annotation)
        repeated = "tuple" in str(field.annotation)
        heading = f"[[{name}]]" if tables and repeated else f"[{name}]" if tables else name
        parts += [f"## `{heading}`\n", (field.description or "") + "\n"]
        for table in tables:
            title = _kind(table) if len(tables) > 1 else None
            parts.append(_section(table, f'### `kind = "{title}"`\n\n' if title else ""))
            inner += [one for one in _inner(table) if one not in inner]
    parts.append("## Values that are tables\n")
    for table in inner:  # it grows where tables hold others
        inner += [one for one in _inner(table) if one not in inner]
        parts.append(_section(table, f"### {table.__name__}\n\n"))
    return "\n".join(parts)


def keys() -> set[str]:
    """Names of all keys of all tables."""
    found: set[str] = set()
    pending, seen = [Scene], set()
    while pending:
        table = pending.pop()
        if table in seen:
            continue
        seen.add(table)
        for name, field in table.model_fields.items():
            found.add(name)
            pending += _tables(field.annotation)
    return found


def _tables(annotation: object) -> list[type[BaseModel]]:
    """The tables that stand somewhere in a type."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    found: list[type[BaseModel]] = []
    for inner in typing.get_args(annotation):
        found += [table for table in _tables(inner) if table not in found]
    return found


def _inner(table: type[BaseModel]) -> list[type[BaseModel]]:
    """The tables that are values of its keys."""
    return [one for field in table.model_fields.values() for one in _tables(field.annotation)]


def _kind(table: type[BaseModel]) -> str | None:
    """What `kind` must be for this table, of several that may stand in one place."""
    field = table.model_fields.get("kind")
    return typing.get_args(field.annotation)[0] if field is not None and field.annotation is not str else None


def _section(table: type[BaseModel], heading: str) -> str:
    rows = [
        f"| `{name}` | {_cell(_wants(field))} | {_cell(_default(field))} |"
        for name, field in table.model_fields.items()
    ]
    return "\n".join(
        [heading + _first_paragraph(table) + "\n", "| key | wants | default |", "|---|---|---|", *rows, ""]
    )


def _wants(field: FieldInfo) -> str:
    names = [table.__name__ for table in _tables(field.annotation)]
    links = ", ".join(f"[{name}](#{name.lower()})" for name in names)
    return (field.description or "") + (f" ({links})" if links else "")


def _first_paragraph(table: type[BaseModel]) -> str:
    return " ".join((table.__doc__ or "").strip().split("\n\n")[0].split())


def _default(field: FieldInfo) -> str:
    if field.is_required():
        return "required"
    value = field.get_default(call_default_factory=True)
    if value is None:
        return "see left" if re.search("unless given|without it", field.description or "") else "none"
    if isinstance(value, BaseModel):
        return "its defaults"
    if isinstance(value, bool):
        return f"`{str(value).lower()}`"
    if isinstance(value, str):
        return f'`"{value}"`'
    if isinstance(value, tuple):
        return f"`{list(value)}`".replace("'", '"')
    return f"`{value:g}`" if isinstance(value, float) else f"`{value}`"


def _cell(text: str) -> str:
    return re.sub(r"\s+", " ", text).replace("|", r"\|")


if __name__ == "__main__":
    Path(__file__).with_suffix(".md").write_text(reference())
