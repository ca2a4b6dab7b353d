"""The documentation names what there is: files, links, scenes, and every key of the scene file."""

import re
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
DOCS = sorted((ROOT / "docs").glob("*.md"))
PAGES = [ROOT / "README.md", *(page for page in DOCS if page.name != "scene_reference.md")]
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
            assert (page.parent / target).exists() or target == "scene_reference.md", target


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_files_that_are_named_exist(page):
    for named in re.findall(r"`((?:[\w.-]+/)*[\w-]+\.py)`", page.read_text()):
        assert any(path.endswith(f"/{named}") for path in SOURCES), named


@pytest.mark.parametrize("page", DOCS, ids=lambda page: page.name)
def test_every_page_is_in_the_index(page):
    assert page.name == "index.md" or re.search(rf"^{page.stem}$", (ROOT / "docs/index.md").read_text(), re.M)


def test_the_reference_tells_every_key_of_the_scene_file():
    text = scene_reference.reference()
    for key in scene_reference.keys():
        assert f"`{key}`" in text or f"[{key}]" in text, key
    assert "| `thickness` | a number > 0" in text
    assert "| `spectral_radius` |" in text and "| `0.3` |" in text
