"""Scene files: finding, reading, changing single values, bundled scenes."""

import re
import tomllib
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from warp_origami.errors import InputError
from warp_origami.scenes import bundled_scenes

from .document import Scene


def load_scene(name_or_path: str | Path, overrides: Iterable[str] = ()) -> Scene:
    """Reads a scene.

    Args:
        name_or_path: name of a bundled scene or path of a .toml file.
        overrides: "key.path=value" with a TOML value, for example "material.thickness=1e-4" or "driver.0.axes=xy";
            elements of arrays of tables by their number from 0.

    Raises:
        InputError: there is no such scene, it is not TOML, or it is not a valid scene.
    """
    path = _find(name_or_path)
    try:
        values = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError("scene", repr(str(name_or_path)), f"a readable file ({error.strerror})") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(str(path), f"invalid TOML: {error}", "a TOML file in UTF-8") from None
    for override in overrides:
        apply_override(values, override)
    _resolve_pattern_file(values, path.parent)
    return Scene(**values)


def _find(name_or_path: str | Path) -> Path:
    path = Path(name_or_path)
    if path.suffix == ".toml" and path.exists():
        return path
    bundled = bundled_scenes()
    if str(name_or_path) in bundled:
        return bundled[str(name_or_path)][0]
    names = ", ".join(bundled) or "none"
    raise InputError("scene", repr(str(name_or_path)), f"the path of a .toml file or a bundled scene ({names})")


def _resolve_pattern_file(values: dict[str, Any], folder: Path) -> None:
    """Makes the path of a FOLD file, which the user gives relative to the scene file, absolute."""
    pattern = values.get("pattern")
    if isinstance(pattern, dict) and isinstance(pattern.get("file"), str) and pattern["file"]:
        pattern["file"] = str(folder.absolute() / pattern["file"])


def apply_override(values: dict[str, Any], override: str) -> None:
    """Sets one value in the tables as read; what it leads to is validated with everything else."""
    path, equals, text = override.partition("=")
    parts = path.strip().split(".")
    if not equals or not all(parts):
        raise InputError("--set", repr(override), "key.path=value, for example material.thickness=1e-4")
    cursor: Any = values
    for k, part in enumerate(parts[:-1]):
        if isinstance(cursor, dict):
            cursor = cursor.setdefault(part, {})
        else:
            cursor = cursor[_index(cursor, part, parts[:k], override)]
        if not isinstance(cursor, dict | list):
            raise InputError(
                f"--set {path}", f"{'.'.join(parts[: k + 1])} = {cursor!r}", "the path of a value in tables"
            )
    last = parts[-1] if isinstance(cursor, dict) else _index(cursor, parts[-1], parts[:-1], override)
    cursor[last] = _value(text.strip(), path)


def _index(items: list, part: str, parents: list[str], override: str) -> int:
    if not part.isdecimal() or int(part) >= len(items):
        wants = f"a number from 0 to {len(items) - 1} after {'.'.join(parents)}"
        raise InputError(f"--set {override}", repr(part), wants)
    return int(part)


def _value(text: str, path: str) -> Any:
    if re.fullmatch(r"[A-Za-z][\w-]*", text) and text not in ("true", "false", "nan", "inf"):
        return text  # a word without quotes, which a shell strips
    try:
        parsed = tomllib.loads(f"value = {text}")
    except tomllib.TOMLDecodeError:
        parsed = {}
    if set(parsed) != {"value"}:
        raise InputError(f"--set {path}", repr(text), "a TOML value: a number, a string, an array or a table")
    return parsed["value"]
