"""Where results may go, told before anything is computed."""

import os
from pathlib import Path

from ..errors import InputError


def check_folder(folder: Path) -> None:
    """Refuses a place where no folder can be, before anything is computed."""
    try:
        existing = next(path for path in [folder, *folder.absolute().parents] if path.exists())
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError("--out", f"{str(folder)[:100]!r} ({reason})", "the path of a folder") from None
    if not existing.is_dir():
        raise InputError("--out", f"{str(existing)!r}, which is a file", "the path of a folder")
    if not os.access(existing, os.W_OK | os.X_OK):
        raise InputError("--out", f"{str(existing)!r}, which cannot be written to", "a folder that can be written to")


def check_file(path: Path, suffix: str) -> None:
    """Refuses the name of a file that cannot be written, before anything is computed."""
    if path.suffix != suffix:
        raise InputError("--out", repr(str(path)), f"a file name that ends in {suffix}")
    if path.is_dir() or not path.absolute().parent.is_dir():
        raise InputError("--out", repr(str(path)), "a file in a folder that exists")
    if not os.access(path.absolute().parent, os.W_OK | os.X_OK):
        raise InputError("--out", repr(str(path)), "a folder that can be written to")
