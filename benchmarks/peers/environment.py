"""The environments that the programs run in: one of its own for the peers, this one for this program."""

import subprocess
import sys
from pathlib import Path

PINNED = {"mujoco": "4.0.0", "exudyn": "1.13.6", "newton": "1.8.0"}


def prepare(folder: Path, programs: list[str]) -> dict[str, str | None]:
    """Makes a virtual environment in `folder` where there is none and installs the pinned peers that it lacks.

    Returns:
        program -> None, or why it is not there.
    """
    python = interpreter(folder)
    if not python.exists():
        print(f"making an environment for the peers in {folder.name}", flush=True)
        subprocess.run([sys.executable, "-m", "venv", str(folder)], check=True)
    return {program: _install(python, program, PINNED[program]) for program in programs}


def interpreter(folder: Path) -> Path:
    """Python of the environment in `folder`."""
    return folder / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")


def _install(python: Path, package: str, version: str) -> str | None:
    asked = f"import importlib.metadata as m; print(m.version({package!r}))"
    found = subprocess.run([python, "-c", asked], capture_output=True, text=True)
    if found.returncode == 0 and found.stdout.strip() == version:
        return None
    print(f"installing {package} {version}", flush=True)
    command = [python, "-m", "pip", "install", "--quiet", f"{package}=={version}"]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode == 0:
        return None
    lines = [line for line in done.stderr.splitlines() if line.startswith("ERROR")]
    return "not installed: " + (lines[-1].removeprefix("ERROR: ") if lines else "pip failed")
