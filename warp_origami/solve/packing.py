"""The state of a run as named arrays, for a checkpoint, and back."""

from typing import Any

import numpy as np

from warp_origami.errors import InputError


def pack(parts: dict[str, Any]) -> dict[str, np.ndarray]:
    """Arrays "name.field" of dataclasses and "name" of numbers and arrays."""
    arrays = {}
    for name, part in parts.items():
        if hasattr(part, "__dataclass_fields__"):
            arrays |= {f"{name}.{field}": np.asarray(value) for field, value in vars(part).items()}
        else:
            arrays[name] = np.asarray(part)
    return arrays


def unpack(arrays: dict[str, np.ndarray], kinds: dict[str, type]) -> dict[str, Any]:
    """What `pack` was given: dataclasses of the given kinds, numbers (float, int) and arrays (np.ndarray).

    Raises:
        InputError: something is missing.
    """

    def value(name: str, kind: type | None):
        if name not in arrays:
            raise InputError("--resume", f"a checkpoint without {name}", "one of this version")
        content = arrays[name]
        content = content.item() if content.ndim == 0 else content.copy()
        return content if kind is None or kind is np.ndarray else kind(content)

    parts = {}
    for name, kind in kinds.items():
        fields = getattr(kind, "__dataclass_fields__", None)
        if fields is None:
            parts[name] = value(name, kind)
        else:
            parts[name] = kind(**{field: value(f"{name}.{field}", None) for field in fields})
    return parts


def pack_memory(name: str, part) -> dict[str, np.ndarray]:
    """Memory of a part of the system (None: it is not there) as arrays "name.key"."""
    return {} if part is None else {f"{name}.{key}": value for key, value in part.state().items()}


def restore_memory(name: str, part, arrays: dict[str, np.ndarray]) -> None:
    """Gives a part of the system (None: it is not there) back what `pack_memory` gave.

    Raises:
        InputError: something is missing.
    """
    if part is None:
        return
    prefix = f"{name}."
    try:
        part.restore({key.removeprefix(prefix): value for key, value in arrays.items() if key.startswith(prefix)})
    except KeyError as missing:
        wants = "one of this version"
        raise InputError("--resume", f"a checkpoint without {prefix}{missing.args[0]}", wants) from missing
