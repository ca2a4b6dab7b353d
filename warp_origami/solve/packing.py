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


def pack_contact(contact) -> dict[str, np.ndarray]:
    """Memory of the contact term (None without contact) as arrays "contact.name"."""
    return {} if contact is None else {f"contact.{name}": value for name, value in contact.state().items()}


def restore_contact(contact, arrays: dict[str, np.ndarray]) -> None:
    """Gives the contact term (None without contact) back what `pack_contact` gave."""
    if contact is not None:
        prefix = "contact."
        contact.restore({n.removeprefix(prefix): value for n, value in arrays.items() if n.startswith(prefix)})
