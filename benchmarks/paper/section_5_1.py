"""Statements of section 5.1: the model, and which contact lets layers through."""

from collections.abc import Sequence

import numpy as np

from .figures import cut
from .places import crease_name, face_name
from .runs import Result
from .statement import Statement, near, verdict
from .watch import Watched

EARLY = 1.65
"""s: until then the layers lie nearly parallel, and depth is a distance across them."""


def model(results: Sequence[Result]) -> list[Statement]:
    """What was taken over, and what was chosen."""
    system, summary = results[2].system, results[2].summary
    mesh, material = system.mesh, system.scene.material
    mass = float(mesh.areas.sum()) * material.density * material.thickness
    centres = mesh.vertices[mesh.triangles].mean(axis=1)
    eighth = int(np.count_nonzero((centres[:, 1] > 0) & (centres[:, 1] < centres[:, 0])))
    contact = system.scene.contact
    q0 = results[2].q[0]
    submesh, interpolation = results[2].submesh(8)
    segments, _ = cut(
        submesh, interpolation @ q0, np.array([1.0, 1.0]) / np.sqrt(2.0), np.array([0.05, 0.05, 0.0]) / np.sqrt(2.0)
    )
    across = segments @ np.array([-1.0, 1.0, 0.0]) / np.sqrt(2.0)
    own = np.abs(across).max(axis=1) < 0.05
    layers = max(
        int(np.count_nonzero((segments[own][:, :, 2] - z).prod(axis=1) < 0.0)) for z in np.linspace(-0.1, 0.0, 41)
    )
    steps = np.diff(results[2].times)
    return [
        Statement(
            "5.1",
            "square of 0.6 m, 0.5 mm, 1420 kg/m^3, 2.5 GPa, 0.34, damping 1.5",
            f"the same; mass {mass:.4f} kg",
            "given",
        ),
        Statement(
            "5.1, Fig. 9",
            "48 elements, 6 in one eighth",
            f"{summary['elements']} elements, {eighth} in one eighth",
            "yes",
        ),
        Statement("5.1", "s1 = s2 = 1e-4", f"{material.s1:g}, {material.s2:g}", "given"),
        Statement(
            "5.1",
            "elements joined by constraints at the nodes of fold lines",
            f"{summary['constraints']} equations, eliminated: {summary['dofs']} of 855 coordinates are free",
            "yes",
        ),
        Statement(
            "Fig. 10",
            "corners driven outwards along the diagonals, z held; the velocity profile is only drawn",
            "the same; a smooth profile over 4 s, to 1.0002 of the flat distance",
            "in part",
        ),
        Statement(
            "5.1",
            "penalties 1e8 (STS), 3e6 (NTS), no friction",
            f"{contact.sts_stiffness:g} N/m^3, {contact.nts_stiffness:g} N/m (edges alike), no friction",
            "given",
        ),
        Statement(
            "5.2",
            "stowed: six layers in a quarter, no stress",
            f"{layers} layers in a quarter, strain energy {results[2].history['strain_energy'][0]:.0e} J",
            verdict(layers == 6, results[2].history["strain_energy"][0] < 1e-12),
        ),
        Statement(
            "5.2",
            "sufficiently small steps are needed",
            f"{len(steps)} steps chosen by the error, {steps[1:].min():.1e} to {steps.max():.1e} s",
            "yes",
        ),
        Statement(
            "5",
            "computing time: not told",
            "; ".join(
                f"Model {k}: {r.summary['steps_accepted']} steps, {r.summary['newton_iterations']} iterations"
                for k, r in enumerate(results, 1)
            ),
            "given",
        ),
    ]


def comparison(results: Sequence[Result], watched: Sequence[Watched]) -> list[Statement]:
    """Fig. 11."""
    first = watched[0]
    mesh, thickness = results[0].system.mesh, results[2].system.scene.contact.thickness
    crossing = np.flatnonzero(first.crosses)
    early = crossing[first.times[crossing] < EARLY]
    deepest = first.crossings[early[np.argmax(first.depths[early])]][0]
    seen = first.crossings[early[np.argmax(first.depths[early])]]
    creases, inner = (sum(getattr(c, name) for c in seen) for name in ("creases", "inner"))
    at = results[0].at(0.5)
    when = first.times[early[np.argmax(first.depths[early])]]
    sts, mixed = watched[1], watched[2]
    place = crease_name(mesh, deepest.flat) or f"inside {face_name(mesh, deepest.face)}"
    first_touch = [float(w.times[w.touching][0]) for w in watched[1:]]
    return [
        Statement(
            "Fig. 11",
            "0.5 s: the models differ visibly",
            f"at {first.times[at]:.2f} s nothing has met; first crossing {first.times[crossing[0]]:.2f} s (Model 1), "
            f"first contact {first_touch[0]:.2f} s (2), {first_touch[1]:.2f} s (3)",
            verdict(near(first.times[crossing[0]], 0.5), bool(first.crosses[at])),
        ),
        Statement(
            "Fig. 11b",
            "Model 1: overpenetration on boundaries and inside of elements",
            f"crosses in {len(crossing)} of {len(first.times)} states, {first.times[crossing[0]]:.2f} to "
            f"{first.times[crossing[-1]]:.2f} s; deepest before {EARLY} s {1e3 * deepest.depth:.1f} mm = "
            f"{deepest.depth / thickness:.0f} thicknesses at {when:.2f} s: {place} beyond "
            f"{face_name(mesh, deepest.beyond)}; {creases} sub-edges of creases and {inner} inner ones pass through",
            verdict(creases > 0, inner > 0),
        ),
        Statement(
            "Fig. 11c",
            "Model 2: large penetration at the fold line",
            f"{sts.penetration.max() / thickness:.0%} of the thickness ({1e3 * sts.penetration.max():.2f} mm) at "
            f"{sts.times[np.argmax(sts.penetration)]:.2f} s at the fold Q1-P2; {int(sts.crosses.sum())} states cross",
            "yes" if sts.crosses.any() else "in part",
        ),
        Statement(
            "Fig. 11d",
            "Model 3: no overpenetration",
            f"deepest {1e6 * mixed.penetration.max():.1f} um = {mixed.penetration.max() / thickness:.1%} of the "
            f"thickness; {int(mixed.crosses.sum())} states cross",
            verdict(not mixed.crosses.any()),
        ),
    ]
