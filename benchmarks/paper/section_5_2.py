"""Statements of section 5.2: shapes, stress, energies and vibrations during the deployment."""

from collections.abc import Sequence

import numpy as np

from .measures import (
    FIRST,
    SECOND,
    flatness,
    most_stressed,
    oscillation,
    peak,
    state_shares,
    stress,
    touched,
    turns_per_second,
    valley,
)
from .places import into_eighth
from .runs import Result
from .statement import Statement, near, verdict
from .watch import Watched

E, F = (0.198125, 0.125), (0.199583333333, 0.183333333333)


def configurations(results: Sequence[Result], watched: Sequence[Watched]) -> list[Statement]:
    """Figs. 12 and 13."""
    mixed = results[2]
    concentrated = {t: stress(mixed, t) for t in (1.0, 1.5, 2.0)}
    ratios = ", ".join(f"{v.max() / np.median(v):.0f} at {t:g} s" for t, v in concentrated.items())
    _, wrinkled3, slack3 = state_shares(mixed, 3.0)
    taut4, wrinkled4, slack4 = state_shares(mixed, 4.0)
    places1, places4 = most_stressed(mixed, 1.0), most_stressed(mixed, 4.0)
    to_corner = np.linalg.norm(places4 - [0.3, 0.3], axis=1).max()
    near_one = [watched[2].touches[n] for n in np.flatnonzero(np.abs(watched[2].times - 1.0) < 0.1)]
    pairs = max(len(touch.forces) for touch in near_one)
    at = into_eighth(np.concatenate([touch.flat.reshape(-1, 2) for touch in near_one]))
    drawn = into_eighth(mixed.surface.submesh.flat)
    beside = np.linalg.norm(drawn[:, None] - at, axis=2).min(axis=1) < 0.02
    pressed = float(stress(mixed, 1.0)[beside].max())
    return [
        Statement(
            "Fig. 12b-d",
            "1.0, 1.5, 2.0 s: stress concentrates in several regions",
            f"largest over median stress: {ratios}",
            verdict(all(v.max() > 10 * np.median(v) for v in concentrated.values())),
        ),
        Statement(
            "Fig. 12e",
            "3.0 s: fully deployed, wrinkles in some areas",
            f"z up to {1e3 * flatness(mixed, 3.0):.0f} mm, {wrinkled3:.0%} wrinkled, {slack3:.0%} slack",
            verdict(flatness(mixed, 3.0) < 0.01, wrinkled3 > 0.0),
        ),
        Statement(
            "Fig. 12f",
            "4.0 s: fully tensioned",
            f"z to {1e3 * flatness(mixed, 4.0):.1f} mm, {taut4:.0%} taut, {wrinkled4:.0%} wrinkled, {slack4:.0%} slack",
            verdict(flatness(mixed, 4.0) < 0.01, slack4 < 0.01, wrinkled4 < 0.01),
        ),
        Statement(
            "Fig. 13a",
            "1.0 s: concentration at a multiple-point contact (A)",
            f"{pairs} pairs press around 1.0 s, at the fold Q1-P2; stress within 20 mm of them up to "
            f"{1e-6 * pressed:.2f} MPa, {pressed / stress(mixed, 1.0).max():.0%} of the largest",
            verdict(pairs > 0, pressed > 0.5 * stress(mixed, 1.0).max()),
        ),
        Statement(
            "Fig. 13a",
            "1.0 s: concentration near fold lines that meet inside the sheet (B, C)",
            "the 2 % with the largest stress lie at the folds from O to P1 and Q1, up to "
            f"{1e-6 * stress(mixed, 1.0).max():.1f} MPa",
            verdict(places1[:, 0].max() < 0.11),
        ),
        Statement(
            "Fig. 13b",
            "4.0 s: concentration at the driven corners (D)",
            f"the 2 % with the largest stress lie within {1e3 * to_corner:.0f} mm of the corners, "
            f"{1e-6 * stress(mixed, 4.0).max():.1f} MPa",
            verdict(to_corner < 0.1),
        ),
    ]


def energies(results: Sequence[Result], watched: Sequence[Watched]) -> list[Statement]:
    """Fig. 14."""
    strain = [result.history["strain_energy"] for result in results]
    kinetic = [result.history["kinetic_energy"] for result in results]
    none, _, mixed = results
    first, second = peak(mixed, strain[2], FIRST), peak(mixed, strain[2], SECOND)
    rise, snap = peak(mixed, strain[2], (1.5, 1.9)), peak(mixed, strain[2], (1.9, 2.4))
    low = valley(mixed, strain[2], (first[0], 1.6))
    last = float(watched[2].times[watched[2].touching][-1])
    unrest = [oscillation(r, s, (0.2, 2.4)) for r, s in ((none, strain[0]), (mixed, strain[2]))]
    between, tense = (_apart(none, strain[0], mixed, strain[2], span) for span in ((2.4, 3.7), (3.8, 4.0)))
    tops = [peak(r, k, (0.0, 2.4)) for r, k in ((none, kinetic[0]), (mixed, kinetic[2]))]
    rate = turns_per_second(none, kinetic[0], (1.9, 2.4))
    return [
        Statement("5.2", "no contact after 2.4 s", f"none after {last:.2f} s", verdict(last <= 2.4)),
        Statement(
            "Fig. 14a",
            "first peak of strain energy at 1.2 s, when the outer layers squeeze the inner",
            f"{first[0]:.2f} s, {1e3 * first[1]:.3f} mJ",
            verdict(near(first[0], 1.2)),
        ),
        Statement(
            "Fig. 14a",
            "valley at 1.4 s, when the outer layers part from the second",
            f"{low[0]:.2f} s, {1e3 * low[1]:.4f} mJ; layers still touch until {last:.2f} s",
            verdict(near(low[0], 1.4)),
        ),
        Statement(
            "Fig. 14a",
            "second peak at 2.0 s",
            f"{1e3 * rise[1]:.2f} mJ at {rise[0]:.2f} s, before the snap; "
            f"{1e3 * snap[1]:.2f} mJ at {snap[0]:.2f} s, after it",
            verdict(near(second[0], 2.0)),
        ),
        Statement(
            "Fig. 14a",
            "strain energy oscillates much more with contact than without",
            f"fast part (r.m.s., 0.2 to 2.4 s) {1e3 * unrest[1]:.3f} mJ with, {1e3 * unrest[0]:.3f} mJ without",
            verdict(unrest[1] > unrest[0]),
        ),
        Statement(
            "Fig. 14a",
            "after the last contact the curves run together",
            f"r.m.s. difference {between:.0%} of the r.m.s. value from 2.4 to 3.7 s, {tense:.0%} from 3.8 s on",
            verdict(between < 0.1, tense < 0.1),
        ),
        Statement(
            "Fig. 14b",
            "kinetic energy larger with contact than without",
            f"largest {1e3 * tops[1][1]:.1f} mJ at {tops[1][0]:.2f} s with, {1e3 * tops[0][1]:.1f} mJ at "
            f"{tops[0][0]:.2f} s without",
            verdict(tops[1][1] > tops[0][1]),
        ),
        Statement(
            "Fig. 14b",
            "kinetic energy of Model 1 oscillates at very high frequencies",
            f"{rate:.0f} maxima a second from 1.9 to 2.4 s",
            verdict(rate > 10.0),
        ),
    ]


def stresses(results: Sequence[Result], watched: Sequence[Watched]) -> list[Statement]:
    """Fig. 15."""
    none, _, mixed = results
    e, f = ([r.probes[name]["von_mises"] for r in (none, mixed)] for name in "EF")
    early, later = peak(mixed, e[1], (0.5, 1.6)), peak(mixed, e[1], SECOND)
    first_e, first_f, top_f = peak(mixed, e[1], (0.5, 1.2)), peak(mixed, f[1], (0.7, 1.2)), peak(mixed, f[1], SECOND)
    at_e, at_f = touched(watched[2], E), touched(watched[2], F)
    span_e, span_f = (watched[2].times[at][[0, -1]] if at.any() else (np.nan, np.nan) for at in (at_e, at_f))
    apart = _apart(none, e[0], mixed, e[1], (1.4, 2.4))
    tops = [peak(r, s, (0.0, 2.4)) for r, s in ((none, e[0]), (mixed, e[1]))]
    return [
        Statement(
            "Fig. 15",
            "E and F are often in contact (their places are only drawn)",
            f"contact within 25 mm of E in {int(at_e.sum())} states, {span_e[0]:.2f} to {span_e[1]:.2f} s; of F in "
            f"{int(at_f.sum())}, {span_f[0]:.2f} to {span_f[1]:.2f} s",
            verdict(at_e.any(), at_f.any()),
        ),
        Statement(
            "Fig. 15a",
            "E, Model 3: peaks at 1.0 and 2.0 s, the first higher",
            f"{1e-6 * first_e[1]:.2f} MPa at {first_e[0]:.2f} s, "
            f"{1e-6 * early[1]:.2f} MPa at {early[0]:.2f} s, {1e-6 * later[1]:.1f} MPa at {later[0]:.2f} s",
            verdict(near(first_e[0], 1.0), near(later[0], 2.0), early[1] > later[1]),
        ),
        Statement(
            "Fig. 15a",
            "E: larger peak in Model 3 than in Model 1",
            f"{1e-6 * tops[1][1]:.1f} MPa with, {1e-6 * tops[0][1]:.1f} MPa without; before 1.2 s "
            f"{1e-6 * first_e[1]:.2f} and {1e-6 * peak(none, e[0], (0.5, 1.2))[1]:.2f} MPa",
            verdict(tops[1][1] > tops[0][1]),
        ),
        Statement(
            "Fig. 15a",
            "E: no contact after 1.4 s, the two curves agree from then on",
            f"last contact near E {span_e[1]:.2f} s; r.m.s. difference {apart:.0%} of the r.m.s. value to 2.4 s",
            verdict(near(span_e[1], 1.4), apart < 0.1),
        ),
        Statement(
            "Fig. 15b",
            "F peaks later than E",
            f"first peaks: E {first_e[0]:.2f} s, F {first_f[0]:.2f} s; largest: E {later[0]:.2f} s, F {top_f[0]:.2f} s",
            verdict(first_f[0] > first_e[0], top_f[0] > later[0] + 0.05),
        ),
        Statement(
            "Fig. 15b",
            "F: contact changes the stress much",
            f"at 1.5 s {1e-6 * np.interp(1.5, mixed.times, f[1]):.2f} MPa with, "
            f"{1e-6 * np.interp(1.5, none.times, f[0]):.2f} MPa without",
            verdict(abs(np.interp(1.5, mixed.times, f[1]) / np.interp(1.5, none.times, f[0]) - 1.0) > 0.2),
        ),
    ]


def vibrations(results: Sequence[Result]) -> list[Statement]:
    """Fig. 16."""
    mixed = results[2]
    heights = {name: mixed.probes[name]["z"] for name in "ABCD"}
    speeds = {name: np.abs(mixed.probes[name]["vz"]) for name in "ABCD"}
    spans = ((0.5, 1.5), (1.5, 2.4), (2.6, 3.2), (3.2, 3.8))
    unrest = [oscillation(mixed, mixed.probes["A"]["vz"], span) for span in spans]
    order = {name: oscillation(mixed, heights[name], (1.5, 3.6)) for name in "ABCD"}
    listed = list(order.values())
    peaks = peak(mixed, speeds["A"], (1.6, 2.4)), peak(mixed, speeds["A"], (2.4, 3.2))
    fastest = max(peak(r, np.abs(r.probes["A"]["vz"]), (0.0, 4.0))[1] for r in results)
    return [
        Statement(
            "Fig. 16a",
            "fast vibration from 1.5 to 2.4 s and again after 2.6 s",
            "fast part of A's vertical velocity (r.m.s.): "
            + ", ".join(f"{u:.3f} m/s {a:g} to {b:g} s" for u, (a, b) in zip(unrest, spans, strict=True)),
            verdict(unrest[1] > 10 * unrest[0], unrest[2] > 10 * unrest[0]),
        ),
        Statement(
            "Fig. 16a",
            "then it fades, for the drive slows down and by damping",
            f"to {unrest[3]:.3f} m/s from 3.2 to 3.8 s",
            verdict(unrest[3] < 0.5 * unrest[2]),
        ),
        Statement(
            "Fig. 16a",
            "amplitude falls from A over B, C to D",
            "fast part of z (r.m.s., 1.5 to 3.6 s): " + ", ".join(f"{n} {1e3 * u:.2f} mm" for n, u in order.items()),
            verdict(all(np.diff(listed) < 0.0)),
        ),
        Statement(
            "Fig. 16a",
            "z of D stays the same",
            f"changes by {np.ptp(heights['D']):.0e} m",
            verdict(np.ptp(heights["D"]) < 1e-9),
        ),
        Statement(
            "Fig. 16b",
            "two peaks of velocity, at 2.0 and 2.7 s",
            f"A: {peaks[0][1]:.2f} m/s at {peaks[0][0]:.2f} s, {peaks[1][1]:.2f} m/s at {peaks[1][0]:.2f} s",
            verdict(near(peaks[0][0], 2.0), near(peaks[1][0], 2.7)),
        ),
        Statement(
            "Fig. 16b",
            "velocity of A up to 7 m/s",
            f"up to {fastest:.2f} m/s",
            verdict(0.5 < fastest / 7.0 < 2.0),
        ),
        Statement(
            "Fig. 16b",
            "points near the centre vibrate more than those far from it",
            "largest vertical velocities: " + ", ".join(f"{n} {s.max():.2f}" for n, s in speeds.items()) + " m/s",
            verdict(all(np.diff([s.max() for s in speeds.values()]) < 0.0)),
        ),
    ]


def _apart(
    one: Result, values: np.ndarray, other: Result, other_values: np.ndarray, span: tuple[float, float]
) -> float:
    """Root mean square of the difference of two curves in a span of time, over that of the second."""
    grid = np.linspace(*span, 1001)
    first, second = np.interp(grid, one.times, values), np.interp(grid, other.times, other_values)
    return float(np.sqrt(np.mean((first - second) ** 2) / np.mean(second**2)))
