"""Mass added to the sheet: M_ij = m int S_i S_j / |area or length| over what carries it, or shares on vertices."""

import numpy as np
from scipy.sparse import csr_matrix, diags

from warp_origami.model.coordinates import Coordinates
from warp_origami.model.edge_traces import HERMITE, edge_traces
from warp_origami.model.mesh import Mesh
from warp_origami.model.selectors import Selection

from .inertia import EXACT_DEGREE
from .loads import carriers
from .quadrature import rule
from .shapes import tabulate


def added_mass(mesh: Mesh, coordinates: Coordinates, selection: Selection) -> csr_matrix:
    """(n, n) mass matrix of 1 kg spread over a selection as `loads.force_weights` spreads a force: positions in kg,
    mixed entries in kg m, gradients in kg m^2."""
    kind, parts = carriers(mesh, selection)
    if kind == "points":
        shares = np.zeros(coordinates.count)
        shares[coordinates.positions[parts]] = 1.0 / len(parts)
        return diags(shares, format="csr")
    if kind == "elements":
        areas, weights = rule(EXACT_DEGREE)
        table = tabulate(mesh, np.repeat(parts, len(areas)), np.tile(areas, (len(parts), 1)))
        at, share = table.interpolation(coordinates), np.outer(mesh.areas[parts], weights).ravel()
        return csr_matrix(at.T @ diags(share / share.sum()) @ at)
    traces = edge_traces(mesh, coordinates, parts, np.zeros(len(parts), dtype=int))
    products = np.array([[(f * g).integ()(1.0) for g in HERMITE] for f in HERMITE])
    scale = traces.lengths / traces.lengths.sum()
    local = np.einsum("e,eai,ab,ebj->eij", scale, traces.matrices, products, traces.matrices, optimize=True)
    rows, columns = np.repeat(traces.rows, 6, axis=1), np.tile(traces.rows, (1, 6))
    return csr_matrix((local.ravel(), (rows.ravel(), columns.ravel())), shape=(coordinates.count, coordinates.count))
