"""A copy of the packages under another name, `single_origami`, whose membrane is float32: for benchmarks only.

Float32 are the membrane, follower pressure and the sums into the tangent matrix. Contact, mass, time integration and
linear algebra stay float64: the split that favours float32 most. Both packages run in one process, side by side.
"""

import importlib
import shutil
import sys
from pathlib import Path
from types import ModuleType

import warp_origami

ROOT = Path(__file__).parents[1]
SINGLE_FILES = ("kernels/membrane kernels/srm kernels/linear kernels/gather kernels/pressure "
                "terms/membrane terms/pressure terms/sparsity").split()  # fmt: skip
HOST_FIXES = {  # what takes its type from NumPy's, and a bound below the smallest float32
    "terms/membrane": ("wp.array(volumes, device", "wp.array(volumes, dtype=real, device"),
    "kernels/srm": ("real(1e-150)", "real(1e-18)"),
}


def import_single(folder: Path) -> ModuleType:
    """The package `single_origami`: this checkout with a float32 membrane, made in `folder`."""
    package = folder / "single_origami"
    shutil.copytree(ROOT / "warp_origami", package, ignore=shutil.ignore_patterns("__pycache__"))
    for part in ("kernels", "scenes"):
        shutil.copytree(ROOT / part, package / part, ignore=shutil.ignore_patterns("__pycache__"))
    precision = package / "kernels" / "precision.py"
    (package / "kernels" / "single.py").write_text(precision.read_text().replace("wp.float64", "wp.float32"))
    for path in package.rglob("*.py"):
        name = path.relative_to(package).with_suffix("").as_posix()
        text = path.read_text().replace("warp_origami", "single_origami")
        if name in SINGLE_FILES:
            text = text.replace("precision import", "single import").replace(*HOST_FIXES.get(name, ("", "")))
        path.write_text(text)
    sys.path.insert(0, str(folder))
    return importlib.import_module("single_origami")


def module_of(package: ModuleType, name: str) -> ModuleType:
    """A module of the product or of its float32 copy."""
    return importlib.import_module(f"{package.__name__}.{name}")


def make_system(package: ModuleType, scene, device=None, clock=None, exact_forces: bool = False):
    """The equations of a scene; with `exact_forces` the float64 product gives the forces, `package` the tangents."""
    system = module_of(package, "system").System(scene, device, clock or module_of(package, "clock").PhaseClock())
    if exact_forces:
        given = scene.model_dump(exclude_unset=True)
        exact = make_system(warp_origami, warp_origami.Scene(**given))
        tangent = system.membrane.linearize
        system.membrane.gradient = exact.membrane.gradient
        system.membrane.linearize = lambda q: (tangent(q), exact.membrane.gradient(q))[1]
        for mine, right in zip(system.external.pressures, exact.external.pressures, strict=True):
            mine.term.force = right.term.force
    return system
