"""The reduced tangent in its fixed structure equals T' K T assembled naively."""

import numpy as np
import pytest
from scipy.sparse import csr_matrix, identity, random_array

from membrane_cases import distorted_sheet
from warp_origami.terms.sparsity import ReducedSparsity

PAIRS = np.triu_indices(9)


def random_blocks(count, seed=0):
    """Element tangents of symmetric 27x27 matrices."""
    blocks = np.random.default_rng(seed).normal(size=(count, 45, 3, 3))
    diagonal = PAIRS[0] == PAIRS[1]
    blocks[:, diagonal] += blocks[:, diagonal].transpose(0, 1, 3, 2)
    return blocks


def assemble(coordinates, blocks):
    full = np.zeros((coordinates.count, 3, coordinates.count, 3))
    for rows, own in zip(coordinates.elements, blocks, strict=True):
        for i, j, block in zip(*PAIRS, own, strict=True):
            full[rows[i], :, rows[j], :] += block
            if i != j:
                full[rows[j], :, rows[i], :] += block.T
    return full.reshape(3 * coordinates.count, -1)


def crease_like(n, seed=1):
    """Mostly identity; some rows combine two or three unknowns, some are empty, some unknowns are used twice."""
    rng = np.random.default_rng(seed)
    dense = np.eye(3 * n)
    for row in rng.choice(3 * n, n, replace=False):
        dense[row] = 0.0
        dense[row, rng.choice(3 * n, rng.integers(0, 4), replace=False)] = rng.normal(size=1)
    return csr_matrix(dense[:, dense.any(axis=0)])


@pytest.fixture(scope="module")
def coordinates():
    return distorted_sheet(3, crease=1)[1]


@pytest.mark.parametrize("kind", ["identity", "crease", "dense", "prescribed"])
def test_equals_the_naive_assembly(coordinates, kind):
    n = coordinates.count
    transform = {
        "identity": lambda: identity(3 * n, format="csr"),
        "crease": lambda: crease_like(n),
        "dense": lambda: csr_matrix(random_array((3 * n, 20), density=0.2, rng=np.random.default_rng(2))),
        "prescribed": lambda: csr_matrix((3 * n, 0)),
    }[kind]()
    blocks = random_blocks(len(coordinates.elements))
    sparsity = ReducedSparsity(coordinates.elements, n, transform)
    expected = transform.T @ assemble(coordinates, blocks) @ transform.toarray()
    for seed in (0, 5):
        blocks = random_blocks(len(coordinates.elements), seed)
        expected = transform.T @ assemble(coordinates, blocks) @ transform.toarray()
        found = sparsity.matrix(sparsity.values(blocks))
        assert found.shape == (transform.shape[1],) * 2
        np.testing.assert_allclose(found.toarray(), expected, atol=1e-13 * np.abs(expected).max(initial=1.0))
        assert np.array_equal(found.toarray(), found.toarray().T)


def test_structure_is_sorted_and_holds_no_more_than_the_product(coordinates):
    transform = crease_like(coordinates.count)
    sparsity = ReducedSparsity(coordinates.elements, coordinates.count, transform)
    matrix = sparsity.matrix(sparsity.values(random_blocks(len(coordinates.elements))))
    columns = [matrix.indices[a:b] for a, b in zip(matrix.indptr[:-1], matrix.indptr[1:], strict=True)]
    assert all((np.diff(column) > 0).all() for column in columns)
    pattern = np.zeros((3 * coordinates.count, 3 * coordinates.count))
    for rows in coordinates.elements:
        local = (3 * rows[:, None] + np.arange(3)).ravel()
        pattern[np.ix_(local, local)] = 1.0
    reduced = abs(transform).T @ pattern @ abs(transform).toarray()
    assert len(sparsity.pattern.indices) == np.count_nonzero(np.tril(reduced))
    assert np.array_equal(sparsity.pattern.indices[sparsity.pattern.indptr[:-1]], np.arange(sparsity.size))


def test_values_of_another_matrix_land_in_their_slots(coordinates):
    n = coordinates.count
    sparsity = ReducedSparsity(coordinates.elements, n, identity(3 * n, format="csr"))
    other = sparsity.matrix(sparsity.values(random_blocks(len(coordinates.elements)))).copy()
    other.data[np.abs(other.data) < 0.5] = 0.0
    other.eliminate_zeros()
    np.testing.assert_array_equal(sparsity.matrix(sparsity.values_of(other)).toarray(), other.toarray())
    far = csr_matrix(([1.0, 1.0], ([0, 3 * n - 1], [3 * n - 1, 0])), shape=(3 * n, 3 * n))
    with pytest.raises(ValueError, match="outside"):
        sparsity.values_of(far)


def test_repeated_gathers_agree_bitwise(coordinates):
    blocks = random_blocks(len(coordinates.elements))
    transform = crease_like(coordinates.count)
    runs = {
        ReducedSparsity(coordinates.elements, coordinates.count, transform).values(blocks).tobytes() for _ in range(3)
    }
    assert len(runs) == 1


def test_a_transform_of_the_wrong_height_is_refused(coordinates):
    with pytest.raises(ValueError, match="three per row of q"):
        ReducedSparsity(coordinates.elements, coordinates.count, identity(coordinates.count, format="csr"))
