"""The command line: commands, help, exit codes, what is written and what is not."""

import json
import subprocess
import sys
import types
from pathlib import Path

import pytest
from click.testing import CliRunner

import feed
from warp_origami.cli import main
from warp_origami.errors import InputError


@pytest.fixture
def scene_file(tmp_path):
    path = tmp_path / "bending.toml"
    path.write_text("# a sheet that rolls up\n" + feed.scene().to_toml())
    return path


@pytest.fixture
def ending():
    """How the next simulated run ends: status and further entries of the summary, or an exception."""
    return {"status": "done"}


@pytest.fixture
def warp_origami(tmp_path, monkeypatch, ending):
    """Runs the command line in an empty folder, with told steps in place of the simulation."""
    monkeypatch.chdir(tmp_path)
    calls = []

    def simulate(scene, observer, until, resume, clock, **options):
        calls.append(options | {"until": until, "resume": resume})
        if "raises" in ending:
            raise ending["raises"]
        return feed.feed(observer, scene, until, start=int(resume["number"]) if resume else 0, **ending)

    monkeypatch.setitem(sys.modules, "warp_origami.solve.simulate", types.SimpleNamespace(simulate=simulate))
    description = [("elements", "16"), ("degrees of freedom", "99")]
    monkeypatch.setitem(
        sys.modules, "warp_origami.description", types.SimpleNamespace(describe=lambda scene: description)
    )

    def invoke(*arguments):
        return CliRunner().invoke(main, [str(argument) for argument in arguments])

    invoke.calls = calls
    return invoke


def rows(path):
    return path.read_text().splitlines()[1:]


def test_every_command_has_help_with_every_option_described(warp_origami):
    known = {"list", "check", "run", "report", "verify", "pareto", "draw", "fold", "sweep"}
    assert set(main.commands) == known
    for name, command in main.commands.items():
        assert command.help
        text = warp_origami(name, "--help").output
        for parameter in command.params:
            if parameter.param_type_name == "option":
                assert parameter.help, parameter.name
                assert parameter.opts[0] in text


def test_help_and_list_do_not_wait_for_warp_or_usd():
    script = (
        "import sys; from click.testing import CliRunner; from warp_origami.cli import main\n"
        "assert CliRunner().invoke(main, ['--help']).exit_code == 0\n"
        "assert CliRunner().invoke(main, ['list']).exit_code == 0\n"
        "import warp_origami; assert 'load_scene' in dir(warp_origami)\n"
        "assert not {'warp', 'pxr', 'scipy'} & set(sys.modules), sys.modules.keys()"
    )
    subprocess.run([sys.executable, "-c", script], check=True)


def test_module_is_the_command():
    ended = subprocess.run([sys.executable, "-m", "warp_origami", "--version"], capture_output=True, text=True)
    assert ended.returncode == 0
    assert ended.stdout.startswith("warp-origami, version ")


def test_list_has_a_line_per_bundled_scene(warp_origami, tmp_path, monkeypatch):
    (tmp_path / "a.toml").write_text('# What it shows\nname = "a"\n')
    (tmp_path / "topic").mkdir()
    (tmp_path / "topic" / "bc.toml").write_text('name = "bc"\n# Another thing\n')
    monkeypatch.setattr("warp_origami.scenes.resources.files", lambda package: tmp_path)
    assert warp_origami("list").output.splitlines() == ["a         What it shows", "topic/bc  Another thing"]


def test_check_prints_aligned_lines_and_writes_nothing(warp_origami, scene_file, tmp_path):
    ended = warp_origami("check", scene_file)
    assert ended.exit_code == 0
    assert ended.output.splitlines() == ["elements            16", "degrees of freedom  99"]
    assert list(tmp_path.iterdir()) == [scene_file]


def test_run_writes_into_a_folder_named_after_the_scene(warp_origami, scene_file, tmp_path):
    ended = warp_origami("run", scene_file)
    assert ended.exit_code == 0
    assert json.loads((tmp_path / "runs" / "bending" / "summary.json").read_text())["status"] == "done"
    assert warp_origami.calls == [{"until": 1.0, "resume": None}]


def test_options_reach_the_simulation(warp_origami, scene_file, tmp_path):
    arguments = ["--out", "here", "--device", "cpu", "--threads", 2, "--until", 0.5, "--set", "material.thickness=1e-4"]
    assert warp_origami("run", scene_file, *arguments).exit_code == 0
    assert warp_origami.calls == [{"until": 0.5, "resume": None, "device": "cpu", "threads": 2}]
    assert len(rows(tmp_path / "here" / "history.csv")) == 21
    assert "thickness = 0.0001" in (tmp_path / "here" / "scene.toml").read_text()


def test_run_that_is_done_names_its_page(warp_origami, scene_file):
    page = Path("runs") / "bending" / "report.html"
    assert warp_origami("run", scene_file).stderr.splitlines()[-1] == f"done: results in {page.parent} (open {page})"
    assert page.exists()


@pytest.mark.parametrize("command", ["run", "pareto"])
def test_end_that_the_scene_does_not_reach_is_wrong_input(warp_origami, scene_file, tmp_path, command):
    ended = warp_origami(command, scene_file, "--until", 5)
    assert ended.exit_code == 2
    assert ended.stderr.startswith("--until: got 5, wants at most the end of the scene, 1 s")
    assert list(tmp_path.iterdir()) == [scene_file]
    assert warp_origami("run", scene_file, "--until", 1).exit_code == 0


def test_quiet_run_says_nothing(warp_origami, scene_file):
    assert warp_origami("run", scene_file, "--quiet").output == ""
    assert "compiling kernels" in warp_origami("run", scene_file).output


@pytest.mark.parametrize("command", ["check", "run"])
def test_wrong_scene_exits_2_with_a_message_and_writes_nothing(warp_origami, scene_file, tmp_path, command):
    ended = warp_origami(command, scene_file, "--set", "material.thickness=0")
    assert ended.exit_code == 2
    assert ended.stderr == "material.thickness: got 0, wants a number > 0: thickness, m\n"
    assert list(tmp_path.iterdir()) == [scene_file]
    assert warp_origami(command, "no_such_scene").exit_code == 2


def test_scene_that_cannot_be_modelled_exits_2_and_writes_nothing(warp_origami, scene_file, tmp_path, ending):
    ending["raises"] = InputError("driver.0", "x of the vertex at (0, 0)", "each component prescribed once")
    ended = warp_origami("run", scene_file, "--quiet")
    assert ended.exit_code == 2
    assert ended.stderr == "driver.0: got x of the vertex at (0, 0), wants each component prescribed once\n"
    assert list(tmp_path.iterdir()) == [scene_file]


@pytest.mark.parametrize(
    "arguments",
    [
        ["--until", "0"],
        ["--until", "nan"],
        ["--threads", "0"],
        ["--colour"],
        ["--out", "bending.toml"],
        ["--out", "x" * 5000],
    ],
)
def test_wrong_options_exit_2(warp_origami, scene_file, tmp_path, arguments):
    assert warp_origami("run", scene_file, *arguments).exit_code == 2
    assert list(tmp_path.iterdir()) == [scene_file]


def test_failed_numerics_exit_3_with_time_reason_and_advice(warp_origami, scene_file, tmp_path, ending):
    ending |= {"status": "failed", "message": "stopped at 0.5 s: no convergence", "advice": "loosen the tolerance"}
    ended = warp_origami("run", scene_file, "--quiet")
    assert ended.exit_code == 3
    assert "stopped at 0.5 s: no convergence; loosen the tolerance" in ended.stderr
    assert len(rows(tmp_path / "runs" / "bending" / "history.csv")) == 41


def test_interrupted_run_exits_130_and_can_go_on(warp_origami, scene_file, tmp_path, ending):
    folder = tmp_path / "runs" / "bending"
    ending["status"] = "interrupted"
    ended = warp_origami("run", scene_file, "--until", 0.5)
    assert ended.exit_code == 130
    assert "--resume" in ended.stderr
    ending["status"] = "done"
    assert warp_origami("run", scene_file, "--resume").exit_code == 0
    assert warp_origami.calls[-1]["resume"]["number"] == 20
    assert [float(row.split(",")[0]) for row in rows(folder / "history.csv")] == [k / 40 for k in range(41)]


def test_interruption_before_the_first_step_exits_130(warp_origami, scene_file, ending):
    ending["raises"] = KeyboardInterrupt()
    assert warp_origami("run", scene_file).exit_code == 130


def test_files_that_cannot_be_written_exit_3(warp_origami, scene_file, ending):
    ending["raises"] = OSError(28, "No space left on device", "history.csv")
    ended = warp_origami("run", scene_file, "--quiet")
    assert ended.exit_code == 3
    assert "No space left on device: 'history.csv'" in ended.stderr


def test_resume_without_a_checkpoint_starts_anew(warp_origami, scene_file):
    assert warp_origami("run", scene_file, "--resume").exit_code == 0
    assert warp_origami.calls[-1]["resume"] is None


def test_resume_of_a_finished_run_changes_nothing(warp_origami, scene_file, tmp_path):
    warp_origami("run", scene_file)
    folder = tmp_path / "runs" / "bending"
    before = {path.name: (path.read_bytes(), path.stat().st_mtime_ns) for path in folder.iterdir()}
    assert warp_origami("run", scene_file, "--resume").exit_code == 0
    assert before == {path.name: (path.read_bytes(), path.stat().st_mtime_ns) for path in folder.iterdir()}
    assert len(warp_origami.calls) == 1


def test_finished_early_end_goes_on_to_the_end_of_the_scene(warp_origami, scene_file, tmp_path):
    warp_origami("run", scene_file, "--until", 0.5)
    assert warp_origami("run", scene_file, "--resume").exit_code == 0
    assert len(rows(tmp_path / "runs" / "bending" / "history.csv")) == 41


def test_resume_with_another_scene_exits_2_and_changes_nothing(warp_origami, scene_file, tmp_path):
    warp_origami("run", scene_file, "--until", 0.5)
    before = (tmp_path / "runs" / "bending" / "history.csv").read_bytes()
    ended = warp_origami("run", scene_file, "--resume", "--set", "material.thickness=1e-3")
    assert ended.exit_code == 2
    assert "another scene" in ended.stderr
    assert (tmp_path / "runs" / "bending" / "history.csv").read_bytes() == before


def test_real_run_from_a_shell(tmp_path):
    scene = feed.scene(duration=5e-3, load=[{"kind": "gravity", "acceleration": [0, 0, -9.81]}])
    (tmp_path / "s.toml").write_text(scene.to_toml())
    command = [sys.executable, "-m", "warp_origami"]
    checked = subprocess.run([*command, "check", "s.toml"], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert "elements            16\n" in checked.stdout
    assert checked.stderr == ""
    assert [path.name for path in tmp_path.iterdir()] == ["s.toml"]
    ran = subprocess.run([*command, "run", "s.toml", "--quiet"], cwd=tmp_path, capture_output=True, text=True)
    assert (ran.returncode, ran.stdout, ran.stderr) == (0, "", "")
    summary = json.loads((tmp_path / "runs" / "bending" / "summary.json").read_text())
    assert summary["status"] == "done"
    assert summary["wall_seconds"] == pytest.approx(sum(summary["phases"].values()))
    last = rows(tmp_path / "runs" / "bending" / "history.csv")[-1]
    assert float(last.split(",")[0]) == pytest.approx(5e-3)
