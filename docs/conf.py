"""The documentation as a site: `sphinx-build -W docs docs/_build` makes it, warnings being errors."""

project = "warp_origami"
extensions = ["myst_parser"]
myst_heading_anchors = 3
html_theme = "furo"
html_title = "warp_origami"
exclude_patterns = ["_build"]
html_show_copyright = False
