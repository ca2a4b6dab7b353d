"""Steps that nothing touches are found without looking at contact on the way; what a step ends in is the same."""

import numpy as np
import pytest

import warp_origami as origami
from warp_origami.solve.newton import NewtonResult
from warp_origami.solve.result import Failure
from warp_origami.solve.step import Stepper
from warp_origami.system import System
from warp_origami.terms.contact import Contact

UNTIL = 8e-5
"""The two sheets of the scene meet at 5e-5 s."""


def sheets():
    return origami.load_scene("two_sheets", ["integrator.step=5e-6", "output.fps=steps"])


def always_with_contact(self, potential, before, touching, tolerance):
    return NewtonResult(before.q.ravel(), 0, Failure("not tried", ""))


@pytest.fixture
def looks(monkeypatch):
    """How often contact was evaluated."""
    count = []
    gradient = Contact.gradient

    def counted(self, q):
        count.append(1)
        return gradient(self, q)

    monkeypatch.setattr(Contact, "gradient", counted)
    return count


def test_the_end_of_every_step_is_that_with_contact_on_the_way(monkeypatch):
    found = origami.simulate(sheets(), device="cpu", until=UNTIL)
    monkeypatch.setattr(Stepper, "_without_contact", always_with_contact)
    expected = origami.simulate(sheets(), device="cpu", until=UNTIL)
    touching = expected.history["contact_energy"] > 0.0
    assert not touching[:8].any()
    assert touching[-2:].all()
    for one, other in zip(found.frames, expected.frames, strict=True):
        np.testing.assert_array_equal(one.nodes, other.nodes)
    np.testing.assert_array_equal(found.history["contact_energy"], expected.history["contact_energy"])


def test_steps_that_nothing_touches_look_at_contact_at_both_ends_only(looks):
    runs = [origami.simulate(sheets(), device="cpu", until=until) for until in (2e-5, 4e-5)]
    assert (runs[1].history["contact_energy"] == 0.0).all()
    steps = sum(run.summary["steps_accepted"] for run in runs)
    # a step: where it is predicted to end, where it does, and the same again, kept, for its energy; four at the start
    assert len(looks) <= 3 * steps + 4 * len(runs)


def test_a_step_that_ends_in_contact_is_taken_again_with_it(monkeypatch):
    """As if contact could not be foreseen: nothing seems to touch where the step is predicted to end."""
    expected = origami.simulate(sheets(), device="cpu", until=UNTIL)
    without, touches, ends = Stepper._without_contact, System.touches, []

    def unforeseen(self, potential, before, touching, tolerance):
        ends.append(None)
        found = without(self, potential, before, touching, tolerance)
        ends[-1] = found.failure
        return found

    def blind(self, q):
        looked_at_end = getattr(self, "looked", False)
        self.looked = not looked_at_end
        return looked_at_end and touches(self, q)

    monkeypatch.setattr(Stepper, "_without_contact", unforeseen)
    monkeypatch.setattr(System, "touches", blind)
    found = origami.simulate(sheets(), device="cpu", until=UNTIL)
    assert any(end is not None for end in ends)
    for one, other in zip(found.frames, expected.frames, strict=True):
        np.testing.assert_array_equal(one.nodes, other.nodes)
