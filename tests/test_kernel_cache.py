"""What a scene does not ask for is not compiled: the kernel cache of a fresh process names what was."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = """
import json, sys
import warp_origami as wo

material = {"density": 1420.0, "youngs_modulus": 2.5e9, "poisson_ratio": 0.34, "thickness": 5e-4, "model": sys.argv[1]}
scene = wo.Scene(
    name="film",
    analysis={"kind": "dynamic", "duration": 2e-3},
    pattern={"kind": "sheet", "nx": 2, "ny": 1, "creases_x": [1], "opening": float(sys.argv[3])},
    material=material,
    load=[{"kind": "gravity", "acceleration": [0.0, 0.0, -9.81]}],
    integrator={"step": 1e-3},
    **({"contact": {"method": sys.argv[2]}} if sys.argv[2] else {}),
)
print(json.dumps(wo.simulate(scene, device="cpu").summary))
"""

CONTACT = {"broadphase", "facet_error", "point_contact"}


@pytest.mark.parametrize(
    ("model", "method", "opening", "expected"),
    [
        ("linear", "", 0.01, {"membrane_linear", "element"}),
        ("srm", "sts", 0.01, {"membrane_srm", "element", *CONTACT}),
        ("linear", "nts", 3.1, {"membrane_linear", "element", *CONTACT}),
    ],
)
def test_what_a_scene_models_is_compiled_and_nothing_else(tmp_path, model, method, opening, expected):
    """Also where layers are far apart: nothing is left to be compiled in the middle of a run."""
    environment = os.environ | {"WARP_CACHE_PATH": str(tmp_path)}
    command = [sys.executable, "-c", SCRIPT, model, method, str(opening)]
    output = subprocess.run(
        command, env=environment, cwd=Path(__file__).parent, check=True, capture_output=True, text=True
    )
    folders = (path.name for path in tmp_path.rglob("wp_*") if path.is_dir())
    compiled = {folder.rsplit(".", 1)[1].rsplit("_", 1)[0] for folder in folders}
    summary = json.loads(output.stdout.splitlines()[-1])
    named = {name.rsplit(".", 1)[1] for name in summary["kernel_modules"]}
    later = {"weighted_rows", "fronts"}  # small: compiled where something touches, or the matrix is large enough
    assert compiled - later == named - later == expected
    assert compiled <= named
    assert f"membrane ({model})" in summary["terms"]
    assert [term for term in summary["terms"] if "contact" in term] == ([f"contact ({method})"] if method else [])
    assert (summary["phases"]["contact"] > 0.0) == bool(method)
