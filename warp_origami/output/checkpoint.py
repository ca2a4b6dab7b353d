"""checkpoint.npz: the state from which a run goes on."""

import hashlib
import io
import zipfile
import zlib
from pathlib import Path

import numpy as np

from warp_origami.errors import InputError
from warp_origami.scene import Scene

from .files import replacing

IDENTITY = "pattern_identity"


def write_checkpoint(path: Path, arrays: dict[str, np.ndarray], identity: str) -> None:
    """Writes the arrays, unless one holds a number that is not finite: the last good checkpoint then stays."""
    for values in arrays.values():
        values = np.asarray(values)
        if values.dtype.kind == "f" and not np.isfinite(values).all():
            return
    content = io.BytesIO()  # a ZIP archive on a full disk would go on trying to write its end
    np.savez(content, **arrays, **{IDENTITY: np.array(identity)})
    with replacing(path) as temporary:
        temporary.write_bytes(content.getbuffer())


def read_checkpoint(path: Path, identity: str) -> dict[str, np.ndarray] | None:
    """The arrays of a checkpoint; None if there is none.

    Raises:
        InputError: it belongs to another pattern or cannot be read.
    """
    if not path.exists():
        return None
    try:
        with np.load(path, allow_pickle=False) as content:
            arrays = {name: content[name] for name in content.files}
    except (OSError, EOFError, ValueError, zipfile.BadZipFile, zlib.error) as error:
        raise InputError("--resume", f"{path} that cannot be read ({error})", "a checkpoint of this program") from None
    if str(arrays.pop(IDENTITY, "")) != identity:
        raise InputError(
            "--resume", f"{path} of another pattern", "the FOLD file that the run was started with, unchanged"
        )
    return arrays


def pattern_identity(scene: Scene) -> str:
    """Digest of the content of the scene's FOLD file, which the scene only names; empty without one."""
    return hashlib.sha256(Path(scene.pattern.file).read_bytes()).hexdigest() if scene.pattern.kind == "fold" else ""
