"""The documentation names what there is: files, links, scenes, and every key of the scene file."""

import re
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.sparse import csc_matrix

from warp_origami.model.coordinates import number_coordinates
from warp_origami.model.refine import refine_pattern
from warp_origami.terms.symmetric import symmetric_part

ROOT = Path(__file__).parents[1]
DOCS = sorted((ROOT / "docs").glob("*.md"))
PAGES = [ROOT / "README.md", *DOCS]
sys.path.insert(0, str(ROOT / "docs"))

import scene_reference  # noqa: E402

SOURCES = [
    f"/{path.relative_to(ROOT).as_posix()}"
    for folder in ("warp_origami", "kernels", "tests", "benchmarks", "docs")
    for path in (ROOT / folder).rglob("*.py")
    if ".peers" not in path.parts
]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_to_files(page):
    for target in re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", page.read_text()):
        if not target.startswith(("http://", "https://")):
            assert (page.parent / target).exists(), target


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_files_that_are_named_exist(page):
    for named in re.findall(r"`((?:[\w.-]+/)*[\w-]+\.py)`", page.read_text()):
        assert any(path.endswith(f"/{named}") for path in SOURCES), named


@pytest.mark.parametrize("page", DOCS, ids=lambda page: page.name)
def test_every_page_is_in_the_index(page):
    assert page.name == "index.md" or re.search(rf"^{page.stem}$", (ROOT / "docs/index.md").read_text(), re.M)


def test_the_reference_tells_every_key_of_the_scene_file():
    text = (ROOT / "docs/scene_reference.md").read_text()
    assert text == scene_reference.reference(), "python docs/scene_reference.py writes it anew"
    for key in scene_reference.keys():
        assert f"`{key}`" in text or f"[{key}]" in text, key
    assert "| `thickness` | a number > 0" in text
    assert "| `spectral_radius` |" in text and "| `0.3` |" in text


def examples():
    """The code of the page for those who add something, by the name that it defines last."""
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "docs/extending.md").read_text(), re.S)
    spaces = [{} for _ in blocks]
    for block, space in zip(blocks, spaces, strict=True):
        exec(block, space)
    return {name: space[name] for space in spaces for name in space}


def test_the_example_of_a_pattern_can_be_simulated():
    pattern = examples()["kite"](0.4, 0.6)
    assert pattern.mesh.areas.sum() == pytest.approx(0.12)
    assert list(pattern.mesh.edge_assignments).count("M") == 1
    assert refine_pattern(pattern, 3).mesh.areas.sum() == pytest.approx(0.12)


def test_the_example_of_a_term_is_the_gradient_of_its_energy():
    mesh = examples()["kite"](0.4, 0.6).mesh
    coordinates = number_coordinates(mesh)
    term = examples()["Foundation"](coordinates, 7.0)
    q, d = np.random.default_rng(0).normal(size=(2, coordinates.count, 3))
    change = (term.gradient(q + 1e-6 * d)[0] - term.gradient(q - 1e-6 * d)[0]) / 2e-6
    assert change == pytest.approx(np.sum(term.gradient(q)[1] * d), rel=1e-8)


def test_the_example_of_a_solver_solves():
    matrix = symmetric_part(csc_matrix(np.diag(np.arange(1.0, 9.0)) + 0.1))
    right = np.arange(8.0)
    found = examples()["ConjugateGradients"]().factorize(matrix).solve(right)
    np.testing.assert_allclose(matrix.full() @ found, right, atol=1e-10)
