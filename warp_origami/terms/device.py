"""Where kernels run."""

import warp as wp

from warp_origami.errors import InputError


def choose_device(name: str | None) -> str:
    """The named device; for None the CPU, as long as nobody has measured from which size on CUDA is faster.

    Raises:
        InputError: no such device on this machine.
    """
    if name is None:
        return "cpu"
    known = ["cpu", *(device.alias for device in wp.get_cuda_devices())]
    if name not in known:
        raise InputError("--device", name, f"one of the devices of this machine: {', '.join(known)}")
    return name
