"""TOML files as tables, within limits that keep any file from taking memory or time."""

import re
import tomllib
from pathlib import Path
from typing import Any

from warp_origami.errors import InputError

LARGEST_FILE = 1_000_000
"""Bytes."""

DEEPEST = 16
"""Tables and arrays within each other, and parts of a key."""

SEVERAL = ("support", "driver", "crease", "mass", "load", "probe", "parameter", "result")
"""Tables that a file may have several of."""

_KEY = r"(?:[\w-]+|\"[^\"\n]*\"|'[^'\n]*')"
_LONG_KEY = re.compile(rf"(?:^|[\[{{,])[ \t]*{_KEY}(?:[ \t]*\.[ \t]*{_KEY}){{{DEEPEST}}}", re.MULTILINE)


def read_toml(path: Path, kind: str) -> dict[str, Any]:
    """The tables of a file; `kind` is what a message calls it (scene, study).

    Raises:
        InputError: it is no regular file, cannot be read, is too large or too deeply nested, or is no TOML.
    """
    try:
        if not path.is_file():  # a pipe or a device would be read for ever
            raise InputError(kind, repr(str(path)), "a regular file")
        with path.open("rb") as file:
            content = file.read(LARGEST_FILE + 1)
    except (OSError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        reason = getattr(error, "strerror", None) or error
        raise InputError(kind, repr(str(path)), f"a readable file ({reason})") from None
    if len(content) > LARGEST_FILE:
        raise InputError(str(path), "a larger file", f"a {kind} file of at most {LARGEST_FILE} bytes")
    try:
        tables = _parse(content.decode())
    except ValueError as error:  # TOMLDecodeError and UnicodeDecodeError too, and numbers of thousands of digits
        raise InputError(str(path), f"invalid TOML: {error}", "a TOML file in UTF-8") from None
    check_depth(tables, str(path))
    return tables


def parse_value(text: str, name: str) -> Any:
    """A TOML value.

    Raises:
        InputError: calling it `name`, if it is none.
    """
    try:
        parsed = _parse(f"value = {text}")
    except ValueError:
        parsed = {}
    if set(parsed) != {"value"}:
        raise InputError(name, repr(text), "a TOML value: a number, a string, an array or a table")
    return parsed["value"]


def _parse(text: str) -> dict[str, Any]:
    """Raises ValueError."""
    if _LONG_KEY.search(text):  # takes the square of its length to read
        raise ValueError(f"a key of more than {DEEPEST} parts")
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ValueError(f"{error}{_hint(text, str(error))}") from None
    except RecursionError:
        raise ValueError(f"arrays or tables nested more than {DEEPEST} deep") from None


def _hint(text: str, message: str) -> str:
    """Where a table of SEVERAL has one bracket in place of two: what to write."""
    at_line = re.search(r"at line (\d+)", message)
    line = text.splitlines()[int(at_line[1]) - 1] if at_line else ""
    name = re.match(r"\s*\[\[?\s*(\w+)\s*\]", line)
    if name is None or name[1] not in SEVERAL:
        return ""
    return f"; each of several is written [[{name[1]}]], with two brackets"


def check_depth(tables: dict[str, Any], name: str) -> None:
    """Refuses tables and arrays that are nested too deeply.

    Raises:
        InputError: calling them `name`.
    """
    level: list[Any] = [tables]
    for _ in range(DEEPEST):
        inner = [part.values() if isinstance(part, dict) else part for part in level]
        level = [item for items in inner for item in items if isinstance(item, dict | list)]
        if not level:
            return
    raise InputError(name, "arrays or tables nested too deeply", f"at most {DEEPEST} within each other")
