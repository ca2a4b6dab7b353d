"""Where kernels run."""

import warp as wp

from warp_origami.errors import InputError

CUDA_PAYS_FROM = 5000
"""Elements from which a CUDA device is preferred when none is named. An estimate: it has not been measured."""


def choose_device(name: str | None, elements: int) -> str:
    """The named device, or for None what should be faster for a sheet of so many elements.

    Raises:
        InputError: no such device on this machine.
    """
    if name is None:
        return "cuda:0" if elements >= CUDA_PAYS_FROM and wp.is_cuda_available() else "cpu"
    known = ["cpu", *(device.alias for device in wp.get_cuda_devices())]
    if name not in known:
        raise InputError("--device", name, f"one of the devices of this machine: {', '.join(known)}")
    return name
