"""Running a scene: the analysis that it asks for, with its threads, its clock and its interrupts."""

import numpy as np
from threadpoolctl import threadpool_limits

from warp_origami.clock import PhaseClock
from warp_origami.errors import InputError
from warp_origami.scene import Scene
from warp_origami.system import System
from warp_origami.terms.threads import available_cores, use_threads

from .dynamic import DynamicRun
from .interrupt import deferred_interrupt
from .loop import loop
from .modal import Modes
from .records import Observer
from .static import StaticRun


def simulate(
    scene: Scene,
    observer: Observer,
    device: str | None = None,
    until: float | None = None,
    resume: dict[str, np.ndarray] | None = None,
    threads: int | None = None,
    clock: PhaseClock | None = None,
) -> dict:
    """Runs a scene and returns its summary (the content of summary.json).

    Args:
        scene: what to run.
        observer: told of everything as it happens.
        device: of Warp, "cpu" (also for None) or "cuda:0".
        until: time (s) or load factor to stop at if that is before the scene's end.
        resume: arrays of an earlier `observer.checkpoint` to go on from.
        threads: that launch kernels on the CPU, each on a core of its own; None: all cores. Results do not depend on
            their number, but for round-off where PARDISO is used, which has as many. The linear algebra of SciPy has
            one thread: more would change the order of its sums, and at these sizes cost more than they save.
        clock: wall time by phase, started earlier if more than this call is to be counted.

    Raises:
        InputError: the scene cannot be modelled, or `until` is no time, or `threads` no number of threads; the observer
            knows nothing but its phase.
    """
    if until is not None and not until > 0.0:
        raise InputError("until", until, "a time (static: a load factor) above 0")
    if threads is not None and threads < 1:
        raise InputError("threads", threads, "a number from 1 on, or None for all cores")
    end = scene.analysis.end if until is None else min(until, scene.analysis.end)
    clock = clock or PhaseClock()
    observer.phase("compiling kernels and setting up (the first run of a scene compiles for some seconds)")
    with threadpool_limits(1), use_threads(threads or available_cores()), deferred_interrupt() as interrupted:
        system = System(scene, device, clock)
        if scene.analysis.kind == "dynamic":
            run = DynamicRun(system, observer, end)
        else:
            run = StaticRun(system, observer, end, Modes(system) if scene.analysis.kind == "modal" else None)
        state = run.start() if resume is None else run.resume(resume)
        return loop(run, state, interrupted)
