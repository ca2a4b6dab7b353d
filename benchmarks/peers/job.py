"""What a program's file is started with and what it answers: one JSON object each, the answer on the last line."""

import json
import sys
import time
from collections.abc import Callable

ANSWER = "answer: "


class Loop:
    """Clock of the simulation loop; what happens before the first use is set-up.

    Used as a context manager around the steps, it counts nothing but them.
    """

    def __init__(self):
        self.setup_wall, self.wall, self.cpu = None, 0.0, 0.0
        self._made = time.perf_counter()

    def __enter__(self):
        self._started = time.perf_counter(), time.process_time()
        if self.setup_wall is None:
            self.setup_wall = self._started[0] - self._made
        return self

    def __exit__(self, *_):
        self.wall += time.perf_counter() - self._started[0]
        self.cpu += time.process_time() - self._started[1]

    def result(self) -> dict:
        """Seconds, for JSON."""
        return {"setup_seconds": self.setup_wall, "loop_seconds": self.wall, "cpu_seconds": self.cpu}


def run(simulate: Callable[[dict], dict]) -> None:
    """Does the job on the command line and prints the answer; a failure of the numerics is an answer."""
    try:
        answer = {"status": "done", **simulate(json.loads(sys.argv[1]))}
    except FloatingPointError as error:
        answer = {"status": str(error)}
    print(ANSWER + json.dumps(answer), flush=True)
