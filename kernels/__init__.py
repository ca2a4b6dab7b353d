"""Device code of warp_origami: NVIDIA Warp functions and kernels, float64, no Python logic.

The folder stands at the top of the checkout but is installed as ``warp_origami.kernels``; under another name it would
collide with the unrelated package ``kernels``.
"""

if __name__ != "warp_origami.kernels":
    raise ImportError(f"import these kernels as warp_origami.kernels, not as {__name__!r}: first pip install -e .")
