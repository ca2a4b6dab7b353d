"""Studies: points, what is refused, what is made, kept, tried again and recorded, in processes and on a cluster."""

import copy
import csv
import itertools
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import fuzz_input
import numpy as np
import pytest
import tomli_w
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st

import warp_origami as wo
from warp_origami.cli import main
from warp_origami.study.sweep import local, plot
from warp_origami.study.sweep.cluster import ClusterWorkers
from warp_origami.study.sweep.document import Study, load_study
from warp_origami.study.sweep.local import Job, LocalWorkers, NoWorkers
from warp_origami.study.sweep.outcome import Outcome
from warp_origami.study.sweep.plan import Run, plan
from warp_origami.study.sweep.points import points
from warp_origami.study.sweep.sweep import Sweep
from warp_origami.study.sweep.table import Row
from warp_origami.study.sweep.worker import run_in

SCENE = """
name = "film"
[analysis]
kind = "dynamic"
duration = 2e-3
[pattern]
kind = "sheet"
width = 0.6
height = 0.6
[material]
density = 1420.0
youngs_modulus = 2.5e9
poisson_ratio = 0.34
thickness = 5e-4
[[support]]
name = "corner"
at = { near = [0.0, 0.0] }
[[load]]
kind = "gravity"
acceleration = [0.0, 0.0, -9.81]
[[probe]]
name = "tip"
at = [0.6, 0.6]
"""
THICKNESS = {"key": "material.thickness", "values": [1e-4, 2e-4, 5e-4]}
STUDY = {
    "name": "films",
    "scene": "film.toml",
    "sampling": {"kind": "grid"},
    "parameter": [THICKNESS],
    "result": [{"name": "lowest (m)", "of": "min(probes.tip.z)"}],
}


def study(**tables):
    return Study(**(STUDY | tables))


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "film.toml").write_text(SCENE)
    return tmp_path


class Here:
    """Makes runs in this process; `made` are the thicknesses of those it was asked for."""

    def __init__(self, ends=None):
        self.made, self.ends = [], ends or {}

    def run(self, jobs):
        """Jobs with outcomes: given ones by thickness, else of real runs."""
        for job in jobs:
            thickness = wo.load_scene(job.folder / "scene.toml").material.thickness
            self.made.append(thickness)
            given = self.ends.get(thickness)
            if isinstance(given, BaseException):
                raise given
            yield job, given or run_in(job.folder, job.until, job.limit)


def swept(folder, asked, workers, out="out"):
    """Makes a study in a folder of results; rows of its table, and how far it was when it ended."""
    progress = Sweep(asked, plan(asked, folder), folder / out).run(workers, lambda progress: None)
    return table(folder, out), progress


def table(folder, out="out"):
    with (folder / out / "sweep.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def test_grid_has_every_combination_and_list_goes_together():
    ranged = {"key": "a.b", "range": [1.0, 100.0], "scale": "log", "count": 3}
    words = {"key": "c", "values": ["x", "y"]}
    found = list(points(study(parameter=[ranged, words])))
    assert found == [(a, c) for a in (1.0, 10.0, 100.0) for c in ("x", "y")]
    counted = {"key": "n", "range": [1, 4], "count": 2, "integer": True}
    assert list(points(study(sampling={"kind": "list"}, parameter=[counted, words]))) == [(1, "x"), (4, "y")]
    assert [type(row[0]) for row in points(study(parameter=[counted]))] == [int, int]


def test_files_of_patterns_lie_beside_their_scene(folder, monkeypatch):
    """Not where the study is started, whatever lies there."""
    for name, width in (("narrow", 0.2), ("wide", 0.4)):
        write_fold(folder / f"{name}.fold", width)
    (folder / "elsewhere").mkdir()
    write_fold(folder / "elsewhere" / "wide.fold", 7.0)
    monkeypatch.chdir(folder / "elsewhere")
    scene = SCENE.replace('kind = "sheet"\nwidth = 0.6\nheight = 0.6', 'kind = "fold"\nfile = "narrow.fold"')
    (folder / "film.toml").write_text(scene.partition("[[probe]]")[0])
    files = {"key": "pattern.file", "values": ["narrow.fold", "wide.fold"]}
    runs = plan(study(parameter=[files], result=[{"name": "kinetic", "of": "history.kinetic_energy"}]), folder)
    assert [run.scene.pattern.file for run in runs] == [str(folder / "narrow.fold"), str(folder / "wide.fold")]


def write_fold(path, width):
    corners = [[0, 0], [width, 0], [width, 0.6], [0, 0.6]]
    path.write_text(json.dumps({"vertices_coords": corners, "faces_vertices": [[0, 1, 2], [0, 2, 3]]}))


def test_latin_hypercube_covers_each_parameter_evenly_and_is_seeded():
    parameters = [
        {"key": "a", "range": [0.0, 10.0]},
        {"key": "b", "range": [1e-4, 1e4], "scale": "log"},
        {"key": "c", "values": ["x", "y"]},
        {"key": "d", "normal": [5.0, 2.0]},
    ]

    def drawn(seed):
        return list(
            points(study(sampling={"kind": "latin_hypercube", "count": 20, "seed": seed}, parameter=parameters))
        )

    a, b, c, d = zip(*drawn(1), strict=True)
    assert sorted(np.floor(np.array(a) * 2).astype(int)) == list(range(20))
    assert sorted(np.floor((np.log10(b) + 4) / 8 * 20).astype(int)) == list(range(20))
    assert sorted(c) == ["x"] * 10 + ["y"] * 10
    assert abs(np.mean(d) - 5.0) < 0.2 and 1.5 < np.std(d) < 2.3
    assert drawn(1) == drawn(1) != drawn(2)


FAULTS = [
    ({"parameter": [{"key": "a b", "values": [1]}]}, "parameter.0.key", "path of a key"),
    ({"parameter": [{"key": "a"}]}, "parameter.0", "exactly one of values, range, normal"),
    ({"parameter": [{"key": "a", "values": []}]}, "parameter.0.values", "list of values"),
    ({"parameter": [{"key": "a", "range": [1, 1], "count": 2}]}, "parameter.0.range", "low < high"),
    ({"parameter": [{"key": "a", "range": [0, 1], "scale": "log", "count": 2}]}, "parameter.0.range", "> 0"),
    ({"parameter": [{"key": "a", "range": [0, 1]}]}, "parameter.0.count", ">= 2"),
    ({"parameter": [{"key": "a", "range": [0, 1], "count": 10**9}]}, "parameter.0.count", "10000"),
    ({"parameter": [THICKNESS, THICKNESS]}, "parameter.1.key", "nothing else sets"),
    ({"set": {"material.thickness": 1}}, "parameter.0.key", "set does"),
    ({"parameter": [{"key": k, "range": [0, 1], "count": 1000} for k in "ab"]}, "parameter", "at most 10000"),
    ({"sampling": {"kind": "list"}, "parameter": [THICKNESS, {"key": "b", "values": [1]}]}, "parameter", "same length"),
    ({"sampling": {"kind": "random"}}, "sampling.kind", "latin_hypercube"),
    ({"sampling": {"kind": "latin_hypercube", "count": 10**7}}, "sampling.count", "10000"),
    ({"parameter": [{"key": "a", "normal": [0, 1]}]}, "parameter.0.normal", "latin_hypercube"),
    ({"result": [{"name": "x", "of": "open('x')"}]}, "result.0.of", "a result"),
    ({"result": [{"name": "x", "of": "surface.volume"}]}, "result.0.of", "tables"),
    ({"result": [{"name": "status", "of": "history.time"}]}, "result.0.name", "no other column"),
    ({"plot": {"of": ["x"]}}, "plot.of.0", "lowest (m)"),
    ({"name": "../x"}, "name", "folder"),
    ({"colour": 1}, "colour", "sampling"),
]


@pytest.mark.parametrize(("change", "key", "wants"), FAULTS, ids=[f"{k}-{w[:12]}" for _, k, w in FAULTS])
def test_faults_of_a_study_are_told_like_those_of_a_scene(change, key, wants):
    with pytest.raises(wo.InputError) as caught:
        study(**change)
    assert caught.value.key == key
    assert wants in caught.value.wants


@pytest.mark.parametrize(
    ("change", "options", "says"),
    [
        ("[[parameter]]\nkey = 'a'\nvalues = [1]\n[sampling]\nkind='grid'", [], "scene: got nothing"),
        ("scene='film.toml'\n[sampling]\nkind='grid'\n[[parameter]]\nkey='material.colour'\nvalues=[1]", [], "colour"),
        ("scene='none.toml'\n[sampling]\nkind='grid'\n[[parameter]]\nkey='a'\nvalues=[1]", [], "none.toml"),
        (None, ["--workers", "2", "--scheduler", "tcp://x:1"], "--workers"),
        (None, ["--scheduler", "tcp://127.0.0.1:1"], "--scheduler: got tcp://127.0.0.1:1"),
        (None, ["--out", "film.toml"], "which is a file"),
    ],
)
def test_a_wrong_study_exits_2_and_writes_nothing(folder, monkeypatch, change, options, says):
    monkeypatch.chdir(folder)
    monkeypatch.setitem(sys.modules, "distributed", None)  # as if it were not installed
    parameter = "[[parameter]]\nkey = 'material.thickness'\nvalues = [1e-4]\n"
    text = "name = 'films'\n" + (change or f"scene = 'film.toml'\n[sampling]\nkind = 'grid'\n{parameter}")
    Path("s.toml").write_text(text)
    ended = CliRunner().invoke(main, ["sweep", "s.toml", *options])
    assert ended.exit_code == 2, ended.output
    assert says in ended.stderr and "Traceback" not in ended.stderr
    assert sorted(path.name for path in folder.iterdir()) == ["film.toml", "s.toml"]


@settings(max_examples=200, deadline=None, derandomize=True, database=None)
@given(st.randoms(use_true_random=False))
def test_a_study_that_has_been_tampered_with_is_refused_in_words_or_planned(chance):
    stretch = {"key": "driver.0.overstretch", "normal": [1e-3, 1e-4]}
    tables = copy.deepcopy(STUDY) | {
        "scene": "single_fold",
        "sampling": {"kind": "latin_hypercube", "count": 3, "seed": 1},
        "parameter": [{"key": "pattern.nx", "range": [2, 8], "integer": True}, stretch, copy.deepcopy(THICKNESS)],
        "result": [{"name": "force", "of": "max(reactions.pulled.fx) / 2"}],
        "plot": {"of": ["force"]},
    }
    for _ in range(chance.choice([1, 1, 2, 3])):
        fuzz_input.mutate(tables, chance, fuzz_input.NASTY)
    with tempfile.TemporaryDirectory() as place:
        path = Path(place, "study.toml")
        path.write_text(tomli_w.dumps(tables), encoding="utf-8")
        try:
            plan(*load_study(path))
        except wo.InputError as error:
            assert all(": got " in line and ", wants " in line for line in str(error).splitlines())


def test_all_runs_are_made_and_stand_in_the_table(folder):
    rows, progress = swept(folder, study(), Here())
    assert [row["status"] for row in rows] == ["done"] * 3
    assert [float(row["material.thickness"]) for row in rows] == THICKNESS["values"]
    for row in rows:
        history = (folder / "out" / row["folder"] / "history.csv").read_text().splitlines()
        assert len(history) == int(row["steps_accepted"]) + 2
        assert float(row["lowest (m)"]) < 0.0
    assert progress.is_final and (folder / "out" / "sweep.png").stat().st_size > 10_000


@pytest.mark.parametrize(
    "values", [[1e-4, 2e-4, 5e-4], [1.25e-5, 2.5e-5], [1e9, 1.75e9, 2.5e9], [0.001, 0.0012], [3, 4, 5], [0.25, 0.5]]
)
def test_labels_of_the_plot_do_not_overlap(tmp_path, values):
    parameters = [{"key": "material.thickness", "values": values}, {"key": "b", "values": [1e-4, 1.1e-4, 1.2e-4]}]
    asked = study(parameter=parameters)
    rows = [
        Row(Run(k, value, None, "", 1.0, ""), Outcome("done"), {"lowest (m)": -1e-5 * k})
        for k, value in enumerate(points(asked))
    ]
    figure = plot.figure(asked, rows)
    figure.canvas.draw()
    for axes in figure.axes:
        low, high = axes.get_xlim()
        labels = [label for place, label in zip(axes.get_xticks(), axes.get_xticklabels(), strict=True)
                  if low <= place <= high]  # fmt: skip
        boxes = sorted((box.x0, box.x1) for box in (label.get_window_extent() for label in labels))
        assert len(boxes) >= 2
        assert all(left[1] + 4 < right[0] for left, right in itertools.pairwise(boxes))
    plot.plt.close(figure)
    plot.draw(tmp_path / "sweep.png", asked, rows)


def test_what_fails_is_recorded_and_the_rest_goes_on(folder):
    asked = study(parameter=[{"key": "material.thickness", "values": [1e-4, -1.0, 2e-4, 5e-4]}])
    ends = {1e-4: Outcome("failed", "no convergence; a smaller step"), 2e-4: Outcome("lost", "its worker died 3 times")}
    rows, progress = swept(folder, asked, Here(ends))
    assert [row["status"] for row in rows] == ["failed", "refused", "lost", "done"]
    assert rows[0]["message"] == "no convergence; a smaller step"
    assert "material.thickness: got -1.0" in rows[1]["message"]
    assert not progress.is_final
    again = Here()
    rows, _ = swept(folder, asked, again)
    assert again.made == [2e-4]  # lost; what has failed would fail again
    assert [row["status"] for row in rows] == ["failed", "refused", "done", "done"]


def test_an_edited_study_makes_only_what_is_new(folder):
    swept(folder, study(), Here())
    edited = study(
        parameter=[THICKNESS | {"values": [5e-4, 3e-4, 1e-4, 5e-4]}], result=[{"name": "last", "of": "probes.tip.z"}]
    )
    workers = Here()
    rows, _ = swept(folder, edited, workers)
    assert workers.made == [3e-4]
    assert [row["status"] for row in rows] == ["done"] * 4
    assert rows[0]["last"] == rows[3]["last"] != ""
    workers = Here()
    swept(folder, study(set={"material.density": 1000.0}), workers)
    assert workers.made == THICKNESS["values"]


def test_an_interrupted_study_keeps_what_has_ended(folder):
    with pytest.raises(KeyboardInterrupt):
        swept(folder, study(), Here({2e-4: KeyboardInterrupt()}))
    assert [row["status"] for row in table(folder)] == ["done", "waiting", "waiting"]
    workers = Here()
    swept(folder, study(), workers)
    assert workers.made == [2e-4, 5e-4]


def test_one_study_at_a_time_in_a_folder(folder):
    class Inside(Here):
        def run(self, jobs):
            with pytest.raises(wo.InputError, match="a study is running"):
                swept(folder, study(), Here())
            yield from super().run(jobs)

    swept(folder, study(), Inside())


def test_frequencies_stand_in_the_table(folder):
    modal = {"analysis": {"kind": "modal", "count": 2}, "load": [], "support": [{"at": {"boundary": True}}]}
    pattern = {"kind": "sheet", "nx": 3, "ny": 3, "initial": {"stretch": [1.001, 1.001]}}
    rows, _ = swept(folder, study(set=modal | {"pattern": pattern}, result=[]), Here())
    assert [row["status"] for row in rows] == ["done"] * 3
    assert float(rows[0]["frequencies.0"]) > 1.0


FAKE = """
import json, os, sys, time
print(json.dumps({"ready": True}), flush=True)
for line in sys.stdin:
    folder = json.loads(line)["folder"]
    begun = os.path.exists(folder)
    open(folder, "a").close()
    if "deadly" in folder or ("weak" in folder and not begun):
        os.kill(os.getpid(), 9)
    if "slow" in folder:
        time.sleep(100)
    print(json.dumps({"status": "done", "message": ""}), flush=True)
"""


@pytest.fixture
def fake(monkeypatch):
    """Workers that only say that they have made a run, and die as the name of its folder says."""
    monkeypatch.setattr(local, "COMMAND", [sys.executable, "-c", FAKE])


def jobs(folder, *names):
    return [Job(name, folder / name, 1.0, None) for name in names]


def test_a_run_whose_worker_dies_is_tried_again_and_given_up_after_three_times(fake, tmp_path):
    asked = jobs(tmp_path, "a", "weak", "deadly", "b", "c")
    found = {job.digest: outcome for job, outcome in LocalWorkers(2).run(asked)}
    assert {name for name, outcome in found.items() if outcome.status == "done"} == {"a", "b", "c", "weak"}
    assert found["deadly"].status == "lost"
    assert "3 times, last killed by signal 9" in found["deadly"].message


def test_workers_that_cannot_start_end_the_study(monkeypatch, tmp_path):
    monkeypatch.setattr(local, "COMMAND", [sys.executable, "-c", "raise SystemExit('no such thing')"])
    with pytest.raises(NoWorkers, match="no such thing"):
        list(LocalWorkers(2).run(jobs(tmp_path, "a", "b")))


def test_no_process_is_left_when_a_study_is_interrupted(fake, tmp_path):
    workers = LocalWorkers(2)
    running = workers.run(jobs(tmp_path, "a", "slow", "b"))
    next(running)
    processes = [worker.process for worker in workers._workers]
    running.close()
    assert processes and all(process.poll() is not None for process in processes)


def test_a_killed_worker_loses_nothing(folder):
    """Real processes: the worker is killed (SIGKILL) when it has made a run, another one makes the rest."""
    asked, killed = study(), []
    workers = LocalWorkers(1)

    def told(progress):
        if progress.statuses.get("done") == 1 and not killed:
            killed.extend(worker.process.pid for worker in workers._workers)
            os.kill(killed[0], signal.SIGKILL)

    progress = Sweep(asked, plan(asked, folder), folder / "out").run(workers, told)
    assert killed and progress.statuses == {"done": 3}
    alone, _ = swept(folder, asked, Here(), "alone")
    assert [row["lowest (m)"] for row in table(folder)] == [row["lowest (m)"] for row in alone]


def test_a_worker_ends_a_run_that_is_out_of_time_and_goes_on_later(folder):
    asked = study(limit=1e-6)
    rows, progress = swept(folder, asked, Here())
    assert [row["status"] for row in rows] == ["out of time"] * 3
    assert "a larger limit" in rows[0]["message"] and not progress.is_final
    rows, _ = swept(folder, study(), Here())
    assert [row["status"] for row in rows] == ["done"] * 3


def heed_interrupts():
    """Programs that a shell starts in the background, and theirs, ignore Ctrl-C."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def test_study_from_a_shell_ends_at_ctrl_c(folder):
    """Interrupted as by Ctrl-C, in the second of two runs, which has a million steps, it ends with 130; started again:
    benchmarks/sweep_worker_killed.py."""
    text = "name = 'films'\nscene = 'film.toml'\n[set]\n'integrator.step' = 1e-4\n[sampling]\nkind = 'grid'\n"
    (folder / "s.toml").write_text(text + "[[parameter]]\nkey = 'analysis.duration'\nvalues = [1e-3, 100.0]\n")
    command = [sys.executable, "-m", "warp_origami", "sweep", "s.toml", "--out", "out", "--workers", "1", "--quiet"]
    process = subprocess.Popen(command, cwd=folder, stderr=subprocess.PIPE, text=True, preexec_fn=heed_interrupts)
    while process.poll() is None and not list(folder.glob("out/runs/*/outcome.json")):
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    assert process.wait(60) == 130
    assert "1 done, 1 waiting" in process.stderr.read()
    assert sorted(row["status"] for row in table(folder)) == ["done", "waiting"]
    assert load_study(folder / "s.toml")[0].name == "films"


def test_a_cluster_makes_runs_and_sends_their_files(folder, tmp_path):
    distributed = pytest.importorskip("distributed")
    options = {"n_workers": 1, "threads_per_worker": 1, "processes": False, "dashboard_address": None}
    with distributed.LocalCluster(**options, silence_logs="CRITICAL") as cluster:
        asked = study(parameter=[THICKNESS | {"values": [1e-4]}])
        rows, _ = swept(folder, asked, ClusterWorkers(cluster.scheduler_address))
    assert rows[0]["status"] == "done", rows
    run = folder / "out" / rows[0]["folder"]
    assert json.loads((run / "summary.json").read_text())["status"] == "done"
    assert wo.load_scene(run / "scene.toml").material.thickness == 1e-4
    assert (run / "animation.usdc").stat().st_size > 0


@pytest.mark.slow
@pytest.mark.parametrize("options", [[], ["--dask", "--kills", "3"]])
def test_fifty_runs_with_workers_killed(options):
    if options:
        pytest.importorskip("distributed")
    script = Path(__file__).parents[1] / "benchmarks" / "sweep_worker_killed.py"
    ended = subprocess.run(
        [sys.executable, script, *options], capture_output=True, text=True, cwd=Path(wo.__file__).parents[1]
    )
    print(ended.stdout, ended.stderr)
    assert ended.returncode == 0


def test_results_of_spin_can_be_asked_for(folder):
    """The same number as in memory; of a scene that does not turn they are refused."""
    spun = SCENE.replace('kind = "gravity"\nacceleration = [0.0, 0.0, -9.81]', 'kind = "initial_spin"\nrate = 3.0')
    spun = spun.replace('[[support]]\nname = "corner"\nat = { near = [0.0, 0.0] }\n', "")
    (folder / "film.toml").write_text(spun)
    wanted = [{"name": "L", "of": "spin.angular_momentum.z"}, {"name": "rate", "of": "max(spin.rate)"}]
    (row,), _ = swept(folder, study(parameter=[THICKNESS | {"values": [5e-4]}], result=wanted), LocalWorkers(1))
    run = wo.simulate(wo.load_scene(folder / "film.toml"), device="cpu")
    assert float(row["L"]) == pytest.approx(run.spin["angular_momentum.z"][-1], rel=1e-12)
    assert float(row["rate"]) == pytest.approx(3.0, rel=1e-3)
    (folder / "film.toml").write_text(SCENE)
    with pytest.raises(wo.InputError, match=r"spin\.rate.*hub or an initial spin"):
        plan(study(result=[{"name": "rate", "of": "spin.rate"}]), folder)
