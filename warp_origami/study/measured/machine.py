"""What measurements of time belong to: the machine and the versions."""

import os
import platform
import sys
from importlib.metadata import version
from pathlib import Path

PACKAGES = {"numpy": "numpy", "scipy": "scipy", "warp": "warp-lang", "warp-origami": "warp-origami"}


def machine() -> dict[str, str | int]:
    """Name of the processor, cores, and versions of Python, the libraries and this program."""
    versions = {name: version(package) for name, package in PACKAGES.items()}
    return {
        "processor": _processor(),
        "cores": os.cpu_count() or 1,
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        **versions,
    }


def _processor() -> str:
    if sys.platform == "linux":
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return " ".join(line.partition(":")[2].split())
    return platform.processor() or platform.machine()
