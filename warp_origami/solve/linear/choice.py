"""Which solver factorizes what."""

from warp_origami.errors import InputError

from . import cudss, pardiso
from .cudss import CuDSS
from .dense import DenseIndefinite, DenseLU
from .interface import Kind, LinearSolver
from .pardiso import Pardiso
from .sparse_cholesky import SparseCholesky
from .superlu import SparseLU

DENSE = 200
"""Unknowns up to which dense LAPACK is as fast as SuperLU for matrices that are not definite."""

PARDISO_FROM = 2000
"""Unknowns from which on "auto" takes PARDISO, where it is installed: below it saves less than it takes to load."""

NAMES = ("auto", "scipy", "pardiso", "cudss")


def choose_solver(name: str, size: int, kind: Kind, device: str = "cpu") -> LinearSolver:
    """The solver that a scene names (`linear_solver`), or what suits `size` unknowns on a device for "auto".

    Raises:
        InputError: no such solver, or not in this installation.
    """
    if name not in NAMES:
        raise InputError("integrator.linear_solver", repr(name), "one of " + ", ".join(f'"{known}"' for known in NAMES))
    if name == "cudss":
        _require(cudss.is_installed(), name, "cuda")
        return CuDSS(kind)
    if name == "pardiso":
        _require(pardiso.is_installed(), name, "fast")
        return Pardiso(kind)
    if name == "auto" and size >= PARDISO_FROM and device != "cpu" and cudss.is_installed():
        return CuDSS(kind)
    if name == "auto" and size >= PARDISO_FROM and pardiso.is_installed():
        return Pardiso(kind)
    if kind == "definite":
        return SparseCholesky()
    if size > DENSE:
        return SparseLU()
    return DenseIndefinite() if kind == "indefinite" else DenseLU()


def _require(installed: bool, name: str, extra: str) -> None:
    if not installed:
        wants = f'an installation with the extra "{extra}": pip install "warp-origami[{extra}]"'
        raise InputError("integrator.linear_solver", f'"{name}", which is not installed', wants)
