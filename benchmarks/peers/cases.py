"""What is run: every program at several meshes and steps, each with settings that suit it.

Squares n x n know nothing of the solution; strips n x 1 use that the swinging sheet hardly varies along its pinned
edge. Steps of explicit methods are nearly the longest stable ones.
"""

from dataclasses import dataclass, field

FILES = {"MuJoCo": "run_mujoco.py", "Exudyn": "run_exudyn.py", "Newton": "run_newton.py", "warp_origami": "run_own.py"}
PACKAGES = {"MuJoCo": "mujoco", "Exudyn": "exudyn", "Newton": "newton"}


@dataclass(frozen=True)
class Case:
    """One run.

    Attributes:
        program: key of FILES.
        settings: as the table names them.
        job: what the program's file is started with.
        quick: whether it is part of a quick comparison.
    """

    program: str
    settings: str
    job: dict
    quick: bool = False
    name: str = field(init=False)

    def __post_init__(self):
        object.__setattr__(self, "name", f"{self.program} {self.job['scene']} {self.settings}")


def _mujoco(scene: str, nx: int, ny: int, step: float, integrator: str = "Euler", quick: bool = False) -> Case:
    label = {"Euler": "explicit", "discrete": "implicit"}[integrator]
    job = {"scene": scene, "nx": nx, "ny": ny, "step": step, "integrator": integrator}
    return Case("MuJoCo", f"{nx} x {ny}, {label}, {step * 1e6:.4g} us", job, quick)


def _exudyn(scene: str, nx: int, ny: int, step: float, radius: float, quick: bool = False) -> Case:
    job = {"scene": scene, "nx": nx, "ny": ny, "step": step, "spectral_radius": radius, "reduced": 1}
    return Case("Exudyn", f"{nx} x {ny}, {step * 1e6:g} us, radius {radius:g}", job, quick)


def _newton(scene: str, nx: int, ny: int, step: float, iterations: int, quick: bool = False) -> Case:
    job = {"scene": scene, "nx": nx, "ny": ny, "step": step, "iterations": iterations}
    return Case("Newton", f"{nx} x {ny}, VBD {iterations}, {step * 1e6:g} us", job, quick)


def _own(scene: str, nx: int, ny: int, settings: dict, note: str = "", quick: bool = False) -> Case:
    step = settings.get("integrator.step", "auto")
    length = f"{step * 1e6:g} us" if step != "auto" else f"tolerance {settings['integrator.tolerance']:g}"
    values = {"pattern.nx": nx, "pattern.ny": ny, **settings}
    job = {"scene": scene, "set": [f"{key}={value}" for key, value in values.items()]}
    return Case("warp_origami", f"{nx} x {ny}, {length}{note}", job, quick)


def _fixed(step: float, radius: float = 1.0, tolerance: float = 1e-2, **more) -> dict:
    """Settings of this program for steps of a fixed size; Newton's tolerance is 1e-4 of `tolerance`."""
    values = {"step": step, "spectral_radius": radius, "tolerance": tolerance, **more}
    return {f"integrator.{key}": value for key, value in values.items()}


def _own_steps(tolerance: float, radius: float) -> dict:
    """Settings of this program for steps of its choice."""
    return {"integrator.step": "auto", "integrator.tolerance": tolerance, "integrator.spectral_radius": radius}


LINEAR = {"integrator.elements": "linear"}
"""Plane triangles, along all of whose edges the sheet may fold."""


def _creases(nx: int) -> dict:
    """Creases along every grid line: a sheet without bending stiffness may fold there, and does."""
    return {"pattern.creases_x": list(range(1, nx))}


CASES = [
    *(_mujoco("swinging", n, n, s, quick=n == 10) for n, s in ((10, 20e-6), (20, 10e-6), (40, 5e-6))),
    *(_mujoco("swinging", n, 1, 0.4e-3 / n, quick=n == 24) for n in (24, 48, 96, 144)),
    _mujoco("swinging", 10, 10, 1e-3, "discrete", quick=True),
    _mujoco("swinging", 24, 1, 1e-4, "discrete"),
    _exudyn("swinging", 6, 6, 1e-4, 0.9),
    _exudyn("swinging", 12, 1, 5e-4, 0.9, quick=True),
    _exudyn("swinging", 12, 1, 1e-4, 0.9),
    _exudyn("swinging", 12, 1, 1e-4, 1.0),
    _newton("swinging", 10, 10, 5e-4, 10, quick=True),
    _newton("swinging", 10, 10, 1e-4, 10),
    _newton("swinging", 24, 1, 1e-4, 10),
    _newton("swinging", 24, 1, 2e-5, 20),
    _own("swinging", 6, 6, _fixed(1e-4)),
    _own("swinging", 6, 6, _fixed(1e-4) | _creases(6), ", creases"),
    _own("swinging", 10, 10, _fixed(2e-4, 0.9) | LINEAR, ", linear"),
    *(_own("swinging", n, 1, _own_steps(4e-5, 0.8) | _creases(n), ", creases") for n in (12, 58)),
    *(
        _own("swinging", n, 1, _fixed(step, 0.9) | LINEAR, ", linear", quick=n == 36)
        for n, step in ((12, 1e-3), (36, 1e-3), (48, 6e-4), (104, 3e-4), (144, 2e-4))
    ),
    *(_mujoco("sagging", n, n, s, quick=n == 10) for n, s in ((10, 20e-6), (22, 10e-6), (44, 5e-6))),
    _mujoco("sagging", 22, 22, 1e-3, "discrete"),
    _exudyn("sagging", 6, 6, 1e-3, 0.9, quick=True),
    _exudyn("sagging", 10, 10, 5e-4, 0.9),
    _newton("sagging", 10, 10, 5e-4, 10, quick=True),
    _newton("sagging", 22, 22, 1e-4, 10),
    _own("sagging", 6, 6, _fixed(5e-4), quick=True),
    _own("sagging", 6, 6, _own_steps(1e-5, 0.8)),
    _own("sagging", 11, 11, _own_steps(1e-5, 0.8)),
]

REFERENCE = {"scene": "swinging", "nx": 384, "ny": 2, "courant": 0.6, "until": 0.4}
"""Job of run_explicit.py that positions are held against."""
