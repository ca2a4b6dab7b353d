"""Recorded launches whose indices are divided among the threads of the CPU.

Every index of these kernels writes what is its own, so that results do not depend, bit by bit, on the division.
"""

from collections.abc import Sequence

import warp as wp

from .threads import Task, team


class Launch:
    """A recorded launch of a kernel over [begin, begin + dim).

    Args:
        kernel: its thread works on the index begin + tid(); `begin` is its last input.
        dim: number of indices; may be changed.
        inputs, outputs: of the kernel, without `begin`.
        device: of Warp.
        grain: least number of indices that are worth a thread: some 150 us of work, thrice the price of waking one.
        begin: the first index.
        falling: the work falls along the indices; every thread then has a part from both ends.
    """

    def __init__(
        self,
        kernel: wp.Kernel,
        dim: int,
        inputs: Sequence,
        outputs: Sequence,
        device: str | wp.Device,
        grain: int,
        begin: int = 0,
        falling: bool = False,
    ) -> None:
        self._kernel, self._inputs, self._outputs = kernel, list(inputs), list(outputs)
        self._device, self._grain, self._begin, self._falling = wp.get_device(device), grain, begin, falling
        self._dim = dim
        self._given: dict[str, object] = {}
        self._commands: list[wp.Launch] = []
        self._planned: tuple[int, int] | None = None
        self._plan: list[list[Task]] = []

    def set_dim(self, dim: int) -> None:
        """Changes the number of indices."""
        self._dim = dim

    def set_param(self, name: str, value: object) -> None:
        """Changes an input, by its name in the kernel."""
        if self._given.get(name) is value:
            return
        self._given[name] = value
        for command in self._commands:
            command.set_param_by_name(name, value)

    def launch(self) -> None:
        """Runs all indices."""
        launch_together([self])

    def plan(self) -> list[list[Task]]:
        """What each thread has to do; of one thread where more would not pay."""
        threads = min(team().size, self._dim // self._grain) if self._device.is_cpu else 1
        wanted = (threads if threads > 1 and team().begin() else 1, self._dim)
        if wanted != self._planned:
            self._plan, self._planned = self._divided(*wanted), wanted
        return self._plan

    def _divided(self, threads: int, dim: int) -> list[list[Task]]:
        if dim == 0:
            return []
        parts = 2 * threads if self._falling and threads > 1 else threads
        bounds = [dim * part // parts for part in range(parts + 1)]
        while len(self._commands) < parts:
            self._commands.append(self._record())
        for command, low, high in zip(self._commands, bounds[:-1], bounds[1:], strict=False):
            command.set_param_by_name("begin", self._begin + low)
            command.set_dim(high - low)
        tasks = [command.launch for command in self._commands[:parts]]
        return [[tasks[i], tasks[-1 - i]] for i in range(threads)] if parts > threads else [[task] for task in tasks]

    def _record(self) -> wp.Launch:
        inputs = [*self._inputs, self._begin]
        command = wp.launch(
            self._kernel, dim=1, inputs=inputs, outputs=self._outputs, device=self._device, record_cmd=True
        )
        for name, value in self._given.items():
            command.set_param_by_name(name, value)
        return command


def launch_together(launches: Sequence[Launch]) -> None:
    """Runs launches that do not depend on each other."""
    work: list[list[Task]] = []
    for launch in launches:
        for i, tasks in enumerate(launch.plan()):
            if i == len(work):
                work.append([])
            work[i] += tasks
    if len(work) == 1:
        for task in work[0]:
            task()
    elif work:
        team().run(work)


def compile_now(kernel: wp.Kernel, device: str | wp.Device) -> None:
    """Compiles a kernel now rather than when it is first launched in mid-run."""
    target = wp.get_device(device)
    # Warp launches with blocks of 1 on the CPU, and compiles for each block size anew
    kernel.module.load(target, block_dim=1 if target.is_cpu else None)
