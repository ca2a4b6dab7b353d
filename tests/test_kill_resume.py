"""Killed runs and full disks: resumed, they give the same numbers; see benchmarks/kill_resume.py."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

import warp_origami

SCRIPT = Path(__file__).parents[1] / "benchmarks" / "kill_resume.py"


def counts(*options):
    """Runs the script in a process of its own, for it forks; moments, kills, same and different results."""
    ended = subprocess.run(
        [sys.executable, str(SCRIPT), *map(str, options)],
        capture_output=True,
        text=True,
        cwd=Path(warp_origami.__file__).parents[1],
    )
    print(ended.stdout, ended.stderr)
    found = re.search(r"(\d+) moments, (\d+) kills: (\d+) the same, (\d+) different", ended.stdout)
    assert found, ended.stderr
    return ended.returncode, *map(int, found.groups())


def test_killed_and_resumed_and_out_of_room_gives_the_same_numbers():
    options = ["--moments", 0, "--operations", 3, "--full", 3, "--cases", "blown,drummed,spun"]
    code, moments, kills, same, different = counts(*options)
    assert (code, moments, same, different) == (0, 6, 6, 0)
    assert kills >= 3


@pytest.mark.slow
def test_killed_at_20_random_moments_and_more():
    code, moments, kills, same, different = counts()
    assert (code, moments, same, different) == (0, 80, 80, 0)
    assert kills >= 60
