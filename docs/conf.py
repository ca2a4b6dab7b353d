"""The documentation as a site: `sphinx-build -W docs docs/_build` makes it, warnings being errors."""

import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

project = "warp_origami"
extensions = ["myst_parser"]
myst_heading_anchors = 3
html_theme = "furo"
html_title = "warp_origami"
exclude_patterns = ["_build"]
html_show_copyright = False


def _write_scene_reference(app):
    """The page is made at every build: it cannot differ from what the program checks."""
    from scene_reference import reference

    page, text = HERE / "scene_reference.md", reference()
    if not page.exists() or page.read_text() != text:
        page.write_text(text)


def setup(app):
    """Called by Sphinx."""
    app.connect("config-inited", lambda app, config: _write_scene_reference(app))
