"""What is refused at the border of a run: which key, what it got, what it wants."""

import importlib.util

import numpy as np
import pytest

import warp_origami as origami
from warp_origami.errors import InputError
from warp_origami.solve.packing import restore_memory
from warp_origami.terms.padded_pattern import PaddedPattern
from warp_origami.terms.symmetric import SymmetricPattern


@pytest.mark.parametrize("threads", [0, -5])
def test_a_number_of_threads_below_one(threads):
    with pytest.raises(InputError, match="threads"):
        origami.simulate(origami.load_scene("single_fold"), until=1e-4, threads=threads)


def test_a_checkpoint_that_lacks_what_this_version_remembers():
    pattern = SymmetricPattern(np.array([0, 1], dtype=np.int32), np.array([0], dtype=np.int32))
    with pytest.raises(InputError, match=r"--resume.*padding\.stamp.*this version"):
        restore_memory("padding", PaddedPattern(pattern), {"time": np.array(1.0)})


@pytest.mark.skipif(importlib.util.find_spec("nvmath") is not None, reason="cuDSS is installed")
def test_check_refuses_a_solver_that_is_not_installed():
    from click.testing import CliRunner

    from warp_origami.cli import main

    found = CliRunner().invoke(main, ["check", "single_fold", "--set", "integrator.linear_solver=cudss"])
    assert found.exit_code == 2
    assert "integrator.linear_solver" in found.output
    assert "cuda" in found.output


def test_linear_solves_are_those_that_were_done(monkeypatch):
    from warp_origami.solve.constraint_form import _EliminatedFactor

    count, direction = [], _EliminatedFactor.direction
    monkeypatch.setattr(_EliminatedFactor, "direction", lambda self, g: (count.append(1), direction(self, g))[1])
    summary = origami.simulate(origami.load_scene("single_fold"), device="cpu", until=0.02).summary
    assert summary["linear_solves"] == len(count) > summary["newton_iterations"]
