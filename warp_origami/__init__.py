"""Deployment of foldable space membranes: ANCF membranes with wrinkling, fold lines and self-contact.

import warp_origami as wo

scene = wo.load_scene("leaf_in")
result = wo.simulate(scene, device="cpu")
"""

from importlib import import_module
from pathlib import Path

_CHECKOUT = Path(__file__).resolve().parents[1]
if (_CHECKOUT / "kernels" / "precision.py").exists():
    # in a checkout kernels/ and scenes/ stand beside the package, not in it as in an installation
    __path__.append(str(_CHECKOUT))

_PLACES = {
    "InputError": "errors",
    "NumericalFailure": "errors",
    "Run": "api",
    "Scene": "scene",
    "load_scene": "scene",
    "simulate": "api",
}

__all__ = ["InputError", "NumericalFailure", "Run", "Scene", "load_scene", "simulate"]


def __getattr__(name: str):
    # on demand (PEP 562): `warp-origami --help` should not wait for Warp and USD
    if name not in _PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_PLACES[name]}", __name__), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *_PLACES])
