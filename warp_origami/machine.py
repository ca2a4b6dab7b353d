"""What measurements of time belong to: the machine and the versions."""

import hashlib
import os
import platform
import sys
from functools import cache
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path

PACKAGES = {"numpy": "numpy", "scipy": "scipy", "warp": "warp-lang", "warp-origami": "warp-origami"}


@cache
def machine() -> dict[str, str | int]:
    """Name of the processor, cores, and versions of Python, the libraries and this program."""
    versions = {name: version(package) for name, package in PACKAGES.items()}
    return {
        "processor": _processor(),
        "cores": os.cpu_count() or 1,
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        **versions,
        "sources": _sources(),
    }


def _sources() -> str:
    """Digest of this program's sources: a version that is being worked on changes between measurements."""
    digest = hashlib.sha256()
    for package in ("warp_origami", "warp_origami.kernels"):
        for path in sorted(Path(find_spec(package).origin).parent.rglob("*.py")):
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def _processor() -> str:
    if sys.platform == "linux":
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return " ".join(line.partition(":")[2].split())
    return platform.processor() or platform.machine()
