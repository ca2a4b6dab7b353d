"""Pattern generators, and the one way from the pattern table of a scene to a pattern."""

from inspect import signature
from pathlib import Path

import numpy as np

from ...errors import InputError
from ..connectivity import ConnectivityError
from ..flat_foldability import check_flat_foldable, flat_folded_vertices
from ..fold import read_fold
from ..limits import check_counts, check_elements
from ..mesh import CREASE
from ..pattern import Pattern
from ..refine import refine_pattern
from .annulus import annulus
from .cross_fold import cross_fold
from .disc import disc
from .leaf_in import leaf_in
from .leaf_out import leaf_out
from .miura import miura
from .sheet import sheet
from .square_twist import square_twist
from .z_fold import z_fold

GENERATORS = {
    "annulus": annulus,
    "cross_fold": cross_fold,
    "disc": disc,
    "leaf_in": leaf_in,
    "leaf_out": leaf_out,
    "miura": miura,
    "sheet": sheet,
    "square_twist": square_twist,
    "z_fold": z_fold,
}


def build_pattern(kind: str, parameters: dict, directory: Path | str = ".", refine: int = 1) -> Pattern:
    """Pattern of a scene.

    Args:
        kind: a generator's name, or "fold" for the FOLD file `parameters["file"]`.
        parameters: arguments of the generator; the key `refine`, if there, is used instead of the argument.
        directory: where a relative file name starts.
        refine: every triangle is split into refine^2 elements.

    Raises:
        InputError: unknown kind or parameter, or what the generator or the file's reader refuses.
    """
    parameters = dict(parameters)
    refine = parameters.pop("refine", refine)
    if refine < 1:
        raise InputError("pattern.refine", refine, "at least 1")
    if kind == "fold":
        return _refined(read_fold(Path(directory) / parameters["file"]), refine)
    if kind not in GENERATORS:
        raise InputError("pattern.kind", repr(kind), f"one of fold, {', '.join(GENERATORS)}")
    try:
        signature(GENERATORS[kind]).bind(**parameters)
    except TypeError as error:
        raise InputError("pattern", str(error), f"the parameters of {kind}") from None
    check_counts(parameters)
    try:
        pattern = GENERATORS[kind](**parameters)
    except ConnectivityError as error:  # parameters that each are allowed, and together leave no room for a face
        raise InputError("pattern", f"a {kind} with faces that have no area ({error})", "larger ones") from None
    if pattern.stowed is not None and np.any(pattern.mesh.edge_kinds == CREASE):
        check_flat_foldable(pattern.mesh, "pattern", kind, flat_folded_vertices(pattern.mesh, pattern.stowed))
    return _refined(pattern, refine)


def _refined(pattern: Pattern, n: int) -> Pattern:
    check_elements("pattern.refine", len(pattern.mesh.triangles) * n**2)
    return refine_pattern(pattern, n)
