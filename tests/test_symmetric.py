"""Symmetric matrices by their lower triangle, what contact adds to them, and their borders."""

import numpy as np
import pytest
from scipy.sparse import bmat, csc_matrix, csr_matrix, diags, identity, random_array

from warp_origami.solve.bordered import BorderedPattern
from warp_origami.terms import padded_pattern
from warp_origami.terms.padded_pattern import PaddedPattern
from warp_origami.terms.symmetric import symmetric_part

SIZE = 40


def chain(seed=0):
    """A sparse symmetric matrix."""
    off = np.random.default_rng(seed).normal(size=SIZE - 1)
    return csc_matrix(diags([off, np.full(SIZE, 5.0), off], [-1, 0, 1]))


def some_rows(count, seed):
    rows = csr_matrix(random_array((count, SIZE), density=0.1, rng=np.random.default_rng(seed)))
    rows.sort_indices()
    return rows


def test_the_lower_triangle_gives_the_whole_matrix():
    for matrix in (chain(), csc_matrix((3, 3)), csc_matrix((0, 0))):
        kept = symmetric_part(matrix)
        assert np.array_equal(kept.full().toarray(), matrix.toarray())
        starts = kept.pattern.indptr[:-1]
        assert np.array_equal(kept.pattern.indices[starts], np.arange(matrix.shape[0]))


def test_entries_outside_of_the_pattern_have_no_place():
    pattern = symmetric_part(chain()).pattern
    assert np.array_equal(pattern.places_of(pattern.indices, pattern.columns), np.arange(len(pattern.indices)))
    with pytest.raises(ValueError, match="outside"):
        pattern.places_of(np.array([30]), np.array([3]))


def test_a_padded_matrix_equals_the_sum_made_afresh():
    padded, base = PaddedPattern(symmetric_part(chain()).pattern), symmetric_part(chain()).pattern
    for seed in range(60):
        matrix, rows = chain(seed), some_rows(1 + seed % 4, seed % 7)
        weights = np.random.default_rng(seed).normal(size=rows.shape[0])
        found = padded.add(symmetric_part(matrix).values, rows, weights)
        expected = matrix + rows.T @ diags(weights) @ rows
        np.testing.assert_allclose(found.full().toarray(), expected.toarray(), rtol=0, atol=1e-13)
    assert len(base.indices) < len(padded.pattern.indices)


def test_the_pattern_stays_for_what_was_there_and_forgets_what_was_not_for_long(monkeypatch):
    monkeypatch.setattr(padded_pattern, "MEMORY", 5)
    values = symmetric_part(chain()).values
    padded = PaddedPattern(symmetric_part(chain()).pattern)
    one, two, three = (csr_matrix(([1.0, 1.0], ([0, 0], [0, far])), shape=(1, SIZE)) for far in (10, 20, 30))
    for rows in (one, two, one, one, two):
        pattern = padded.add(values, rows, np.ones(1)).pattern
    assert padded.growths == 2
    for _ in range(6):
        assert padded.add(values, two, np.ones(1)).pattern is pattern
    grown = padded.add(values, three, np.ones(1)).pattern
    assert grown is not pattern
    far = grown.indices[grown.indptr[0] : grown.indptr[1]]
    assert list(far) == [0, 1, 20, 30]


def test_a_bordered_matrix_equals_that_of_blocks():
    equations = csr_matrix(random_array((6, SIZE), density=0.2, rng=np.random.default_rng(4)))
    for border in (equations, equations[:0]):
        pattern = BorderedPattern(symmetric_part(chain()).pattern, border)
        for seed in range(3):
            found = pattern.matrix(symmetric_part(chain(seed)).values).full()
            zeros = 0.0 * identity(border.shape[0])
            np.testing.assert_array_equal(found.toarray(), bmat([[chain(seed), border.T], [border, zeros]]).toarray())


def test_what_a_padded_pattern_remembers_goes_through_a_checkpoint():
    values = symmetric_part(chain()).values
    whole, resumed = (PaddedPattern(symmetric_part(chain()).pattern) for _ in range(2))
    for seed in range(40):
        whole.add(values, some_rows(2, seed % 9), np.ones(2))
    resumed.restore(whole.state())
    for seed in range(40, 80):
        one, two = (padded.add(values, some_rows(2, seed % 11), np.ones(2)) for padded in (whole, resumed))
        assert np.array_equal(one.pattern.indices, two.pattern.indices)
        assert one.values.tobytes() == two.values.tobytes()
