"""Validation errors as messages for the user: key path, value found, what is wanted."""

import typing
from typing import Any

from pydantic import BaseModel, ValidationError

from warp_origami.errors import InputError

MOST_FAULTS = 100
"""That are told of: an array may have as many as it has elements."""


def input_error(error: ValidationError, values: dict[str, Any], table: type[BaseModel]) -> InputError:
    """The faults of `values` (a table of kind `table`, as given) as one InputError, a line for each."""
    faults: dict[str, tuple[str, str, str]] = {}
    for details in error.errors(include_url=False)[:MOST_FAULTS]:
        cause = details.get("ctx", {}).get("error")
        if isinstance(cause, InputError):  # from a file that the scene names: it knows best
            return cause
        path = _path(details, values)
        fault = _explain(details, path, table)
        faults.setdefault(fault[0], fault)
    # a value that may be one of several things fails each of them: what lies deepest is what the user meant
    keys = [key for key in faults if not any(other.startswith(key + ".") for other in faults)]
    first, *rest = (InputError(*faults[key]) for key in keys)
    return first.and_also(rest)


def _path(details: dict, values: Any) -> list[str | int]:
    """The place in the file: the location without what pydantic adds for unions."""
    path, cursor = [], values
    for k, part in enumerate(details["loc"]):
        found = None
        if isinstance(cursor, dict) and part in cursor:
            found = cursor[part]
        elif isinstance(cursor, BaseModel) and isinstance(part, str) and part in type(cursor).model_fields:
            found = getattr(cursor, part)
        elif hasattr(cursor, "__getitem__") and isinstance(part, int) and part < len(cursor):
            found = cursor[part]
        elif not (details["type"] == "missing" and k == len(details["loc"]) - 1):
            continue
        path.append(part)
        cursor = found
    return path


def _explain(details: dict, path: list[str | int], table: type[BaseModel]) -> tuple[str, str, str]:
    kind, context = details["type"], details.get("ctx", {})
    wants, siblings = _field(details["loc"], table)
    got = show(details["input"])
    if kind == "fault":
        path = [*path, context["key"]] if context["key"] else path
        got, wants = context["got"], context["wants"]
    elif kind == "missing":
        got = "nothing"
    elif kind == "extra_forbidden":
        got, wants = f"an unknown key (value {got})", "one of the keys " + ", ".join(siblings)
    elif kind == "union_tag_invalid":
        path, got = [*path, "kind"], show(context["tag"])
        wants = "one of the kinds of this version: " + context["expected_tags"].replace("'", '"')
    elif kind == "union_tag_not_found":
        path, got, wants = [*path, "kind"], "nothing", "a kind: " + ", ".join(f'"{tag}"' for tag in siblings)
    return ".".join(map(str, path)), got, wants or details["msg"]


def _field(location: tuple[str | int, ...], table: type[BaseModel]) -> tuple[str | None, list[str]]:
    """Description of the field at a location, and the names that could stand there: keys of the table, or its kinds."""
    tables, description, names = [table], None, list(table.model_fields)
    for part in location:
        holders = [holder for holder in tables if part in holder.model_fields]
        tagged = [holder for holder in tables if _tag(holder) == part]
        if holders:
            field = holders[0].model_fields[part]
            description, names = field.description, list(holders[0].model_fields)
            tables = list(_tables(field.annotation))
            if tables:
                names = list(tables[0].model_fields) if len(tables) == 1 else [_tag(one) for one in tables]
        elif tagged:
            tables = tagged
            names = list(tagged[0].model_fields)
    return description, names


def places_of(key: str, table: type[BaseModel]) -> list[str]:
    """Where a key stands in the tables of a table: material.thickness, support.0.at."""
    found = []
    for name, field in table.model_fields.items():
        if any(key in inner.model_fields for inner in _tables(field.annotation)):
            several = typing.get_origin(field.annotation) is tuple
            found.append(f"{name}.0.{key}" if several else f"{name}.{key}")
    return found


def _tag(table: type[BaseModel]) -> str | None:
    kind = table.model_fields.get("kind")
    values = typing.get_args(kind.annotation) if kind else ()
    return values[0] if len(values) == 1 else None


def _tables(annotation: Any):
    """The tables that a field's annotation holds, however nested."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for argument in typing.get_args(annotation):
        yield from _tables(argument)


def show(value: Any) -> str:
    """A value as the user wrote it, shortened."""
    if isinstance(value, bool):
        text = "true" if value else "false"
    elif isinstance(value, str):
        text = f'"{value}"'
    elif isinstance(value, tuple):
        text = repr(list(value))
    else:
        text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
