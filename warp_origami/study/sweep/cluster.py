"""Runs on the workers of a Dask cluster, wherever these are: scenes are sent, files come back."""

import contextlib
import json
import logging
import subprocess
import tempfile
import tomllib
import uuid
from collections.abc import Iterator, Sequence
from pathlib import Path

import tomli_w

from warp_origami.errors import InputError
from warp_origami.output.files import replacing
from warp_origami.scene.toml import read_toml

from .local import COMMAND, TRIES, Job
from .outcome import LOST, Outcome
from .worker import SCENE

PIPES = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}

WATCHED_EVERY = 1.0
"""Seconds between looks at whether a run is still wanted."""

CONNECT = "20s"
"""How long a scheduler may take to answer."""


class ClusterWorkers:
    """Makes runs by a Dask scheduler, each in a process of its own on a worker.

    Raises:
        InputError: distributed is not installed, or no scheduler answers at the address.
    """

    def __init__(self, address: str):
        try:
            import distributed
        except ImportError:
            wants = 'the extra "dask": pip install "warp-origami[dask]"'
            raise InputError("--scheduler", f"{address}, but Dask is not installed", wants) from None
        logging.getLogger("distributed").setLevel(logging.CRITICAL)  # what is lost is told in the table
        self._distributed = distributed
        try:
            self._client = distributed.Client(address, timeout=CONNECT, set_as_default=False)
        except (OSError, ValueError, ImportError, TimeoutError) as error:
            reason = str(error).splitlines()[0] if str(error) else type(error).__name__
            wants = "the address of a running Dask scheduler, for example tcp://host:8786"
            raise InputError("--scheduler", f"{address} ({reason})", wants) from None

    def run(self, jobs: Sequence[Job]) -> Iterator[tuple[Job, Outcome]]:
        """Jobs with their outcomes as they end; on any exception, and when it is closed, the rest is cancelled."""
        futures = {}
        try:
            for job in jobs:
                task = {
                    "scene": (job.folder / SCENE).read_text(encoding="utf-8"),
                    "until": job.until,
                    "limit": job.limit,
                }
                fold = _fold_file(job)
                # Dask itself gives a task of a worker that died to another one, distributed.scheduler.allowed-failures
                # times; a process on the worker that died is `retries`
                key = f"warp_origami-{job.digest}-{uuid.uuid4().hex[:8]}"
                future = self._client.submit(run_here, task, fold, key=key, retries=TRIES - 1)
                futures[future] = job
            for future in self._distributed.as_completed(list(futures), loop=self._client.loop):
                yield futures[future], self._taken(future, futures[future])
                future.release()
        finally:
            with contextlib.suppress(Exception):  # a scheduler that is gone has nothing to cancel
                self._client.cancel(list(futures))
            self._client.close(timeout=5)

    def _taken(self, future, job: Job) -> Outcome:
        """The outcome of a task that has ended; the files that it gave are put into the folder of its run."""
        if future.status != "finished":
            error = future.exception() if future.status == "error" else None
            reason = str(error).splitlines()[0] if error is not None and str(error) else type(error).__name__
            return Outcome(LOST, reason if error is not None else f"{future.status}: the scheduler is gone")
        told, files = future.result()
        for name, content in files.items():
            if name != SCENE:  # there, the FOLD file is elsewhere
                with replacing(job.folder / Path(name).name) as temporary:
                    temporary.write_bytes(content)
        return Outcome(told["status"], told["message"])


def _fold_file(job: Job) -> bytes | None:
    """Content of the FOLD file of a scene."""
    pattern = read_toml(job.folder / SCENE, "scene")["pattern"]
    return Path(pattern["file"]).read_bytes() if pattern["kind"] == "fold" else None


def run_here(task: dict, fold: bytes | None) -> tuple[dict, dict[str, bytes]]:
    """What came of a run made on this machine in a process of its own, and its files by name.

    Raises:
        RuntimeError: the process died.
    """
    with tempfile.TemporaryDirectory(prefix="warp_origami-") as place:
        folder = Path(place)
        tables = tomllib.loads(task["scene"])
        if fold is not None:
            (folder / "pattern.fold").write_bytes(fold)
            tables["pattern"]["file"] = str(folder / "pattern.fold")
        run = folder / "run"
        run.mkdir()
        (run / SCENE).write_text(tomli_w.dumps(tables), encoding="utf-8")
        asked = {"folder": str(run), "until": task["until"], "limit": task["limit"]}
        process = subprocess.Popen(COMMAND, text=True, **PIPES)
        said, errors = _conversation(process, json.dumps(asked) + "\n")
        answers = [json.loads(line) for line in said.splitlines()]
        if len(answers) < 2:
            words = (errors.strip().splitlines() or [""])[-1]
            raise RuntimeError(f"the process of the run died with exit code {process.returncode}: {words}")
        return answers[-1], {path.name: path.read_bytes() for path in run.iterdir() if path.is_file()}


def _conversation(process: subprocess.Popen, asked: str) -> tuple[str, str]:
    """What a process answers and writes to its standard error; it is ended when nobody waits for the task any more."""
    from distributed import get_worker

    worker = get_worker()
    key, question = worker.get_current_task(), asked
    while True:
        try:
            return process.communicate(question, timeout=WATCHED_EVERY)
        except subprocess.TimeoutExpired:
            question = None  # given already
        task = worker.state.tasks.get(key)
        if task is None or task.state == "cancelled":
            process.terminate()
