"""Scene files: finding, reading, changing single values, bundled scenes."""

import difflib
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from warp_origami.errors import InputError
from warp_origami.scenes import bundled_scenes

from .document import Scene
from .faults import places_of
from .toml import check_depth, parse_value, read_toml


def load_scene(name_or_path: str | Path, overrides: Iterable[str] = ()) -> Scene:
    """Reads a scene.

    Args:
        name_or_path: name of a bundled scene or path of a .toml file.
        overrides: "key.path=value" with a TOML value, for example "material.thickness=1e-4" or "driver.0.axes=xy";
            elements of arrays of tables by their number from 0.

    Raises:
        InputError: there is no such scene, it is not TOML, or it is not a valid scene.
    """
    return Scene(**load_tables(name_or_path, overrides))


def load_tables(name_or_path: str | Path, overrides: Iterable[str] = ()) -> dict[str, Any]:
    """The tables of a scene as `load_scene` gives them to Scene: changed, the path of a FOLD file absolute.

    Raises:
        InputError: there is no such scene, or it is not TOML.
    """
    path = _find(name_or_path)
    tables = read_toml(path, "scene")
    for override in overrides:
        apply_override(tables, override)
    check_depth(tables, str(path))
    resolve_pattern_file(tables, path.parent)
    return tables


def scene_folder(name_or_path: str | Path) -> Path:
    """Where the paths in a scene start.

    Raises:
        InputError: there is no such scene.
    """
    return _find(name_or_path).parent


def _find(name_or_path: str | Path) -> Path:
    path = Path(name_or_path)
    if path.suffix == ".toml" and path.exists():
        return path
    bundled, name = bundled_scenes(), str(name_or_path)
    if name in bundled:
        return bundled[name][0]
    raise InputError("scene", repr(name), _wanted_scene(path, name, list(bundled)))


def _wanted_scene(path: Path, name: str, bundled: list[str]) -> str:
    """What to give in place of a scene that there is not."""
    if path.suffix == ".fold":
        table = f'[pattern] kind = "fold", file = "{path.name}"'
        return f"a scene, a .toml file with {table} and a material; `warp-origami draw` takes a FOLD file as it is"
    by_word = {word: scene for scene in bundled for word in (scene.rpartition("/")[2], scene)}
    close = dict.fromkeys(by_word[word] for word in difflib.get_close_matches(path.stem, by_word, cutoff=0.7))
    close |= dict.fromkeys(by_word[word] for word in difflib.get_close_matches(name, by_word, cutoff=0.7))
    told = f"did you mean {' or '.join(close)}? " if close else ""
    return f"the path of a .toml file that exists or a bundled scene ({told}`warp-origami list` names them all)"


def resolve_pattern_file(values: dict[str, Any], folder: Path) -> None:
    """Makes the path of a FOLD file, which the user gives relative to the scene file, absolute."""
    pattern = values.get("pattern")
    if isinstance(pattern, dict) and isinstance(pattern.get("file"), str) and pattern["file"]:
        pattern["file"] = str(folder.absolute() / pattern["file"])


def apply_override(tables: dict[str, Any], override: str) -> None:
    """Sets one value in the tables as read; what it leads to is validated with everything else."""
    key, equals, text = override.partition("=")
    key = key.strip()
    if not equals or not all(key.split(".")):
        raise InputError("--set", repr(override), "key.path=value, for example material.thickness=1e-4")
    if "." not in key and key not in Scene.model_fields and (places := places_of(key, Scene)):
        raise InputError(f"--set {key}", "a key without its table", " or ".join(f"{place}=..." for place in places[:6]))
    set_value(tables, key, _value(text.strip(), key), f"--set {key}", f"--set {override}")


def set_value(tables: dict[str, Any], key: str, value: Any, name: str, whole: str | None = None) -> None:
    """Sets the value at a key path (driver.0.profile.end), making the tables on the way that are not there.

    Args:
        tables: as read.
        name: what to call the key in a message; `whole` where an array has no such element.

    Raises:
        InputError: the path leads through something that is no table, or an array has no such element.
    """
    parts, whole = key.split("."), whole or name
    cursor: Any = tables
    for k, part in enumerate(parts[:-1]):
        if isinstance(cursor, dict):
            cursor = cursor.setdefault(part, {})
        else:
            cursor = cursor[_index(cursor, part, parts[:k], whole)]
        if not isinstance(cursor, dict | list):
            raise InputError(name, f"{'.'.join(parts[: k + 1])} = {cursor!r}", "the path of a value in tables")
    last = parts[-1] if isinstance(cursor, dict) else _index(cursor, parts[-1], parts[:-1], whole)
    cursor[last] = value


def _index(items: list, part: str, parents: list[str], whole: str) -> int:
    if not part.isdecimal() or len(part) > 9 or int(part) >= len(items):
        wants = f"a number from 0 to {len(items) - 1} after {'.'.join(parents)}"
        raise InputError(whole, repr(part), wants)
    return int(part)


def _value(text: str, path: str) -> Any:
    if re.fullmatch(r"[A-Za-z][\w-]*", text) and text not in ("true", "false", "nan", "inf"):
        return text  # a word without quotes, which a shell strips
    return parse_value(text, f"--set {path}")
