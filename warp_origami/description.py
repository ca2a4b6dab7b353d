"""What a scene models, in words, without running it."""

import numpy as np

from .clock import PhaseClock
from .model.generators import build_pattern
from .model.pattern_report import describe_pattern
from .model.prescribed import prescribed_motion
from .scene import Scene
from .scene.settings import Contact as ContactTable
from .system import System


def describe(scene: Scene) -> list[tuple[str, str]]:
    """What `check` prints: sizes and what will be modelled, without running."""
    system = System(scene, "cpu", PhaseClock())
    constraints = system.constraints
    folds, ties = constraints.folds, constraints.ties
    kind = "of linear elements" if system.mesh.linear else "fold"
    prescribed = len(constraints.sources) - folds - ties
    pattern = build_pattern(scene.pattern.kind, scene.pattern.parameters() | {"refine": 1}, scene.directory)
    lines = [
        ("scene", scene.name),
        ("analysis", _describe_analysis(scene)),
        ("elements", str(len(system.mesh.triangles))),
        ("faces", str(int(system.mesh.faces.max()) + 1)),
        ("degrees of freedom", f"{constraints.null_space.shape[1]} of {3 * system.coordinates.count} coordinates"),
        (
            "constraints",
            f"{folds} {kind}, {f'{ties} of the hub, ' if ties else ''}{prescribed} prescribed, "
            f"{constraints.dropped} redundant dropped; "
            f"{'by elimination' if scene.integrator.constraints == 'eliminate' else 'by multipliers'}",
        ),
        *_describe_motion(system),
        ("mass", _describe_mass(system)),
        ("terms", ", ".join(system.terms)),
        ("kernel modules", ", ".join(system.kernel_modules)),
    ]
    lines[2:2] = describe_pattern(pattern)
    if system.contact is not None:
        lines += _describe_stiffness(scene.contact, system.contact_settings)
        lines += system.contact.summary().lines()
    return lines


def _describe_motion(system: System) -> list[tuple[str, str]]:
    """What supports and drivers hold, where that is on the flat sheet, and how far drivers go."""
    constraints, mesh = system.constraints, system.mesh
    motion, _, _ = prescribed_motion(constraints.prescribers, constraints.rows, system.scene.analysis.end)
    lines = []
    for k, prescriber in enumerate(constraints.prescribers):
        vertices = prescriber.selection.vertices
        if not len(vertices):  # the hub
            continue
        x, y = mesh.vertices[vertices].T
        place = f"vertex {vertices[0]} at ({x[0]:.6g}, {y[0]:.6g})"
        if len(vertices) > 1:
            place = f"{len(vertices)} vertices, x {x.min():.6g} to {x.max():.6g}, y {y.min():.6g} to {y.max():.6g}"
        components = ", ".join("xyz"[c] for c in prescriber.components)
        said = f"{place}: holds {components}"
        if prescriber.motion is not None:
            mine = (constraints.rows.prescribers == k) & ~constraints.rows.slopes
            way = np.linalg.norm((motion - constraints.rows.initial)[mine][:, list(prescriber.components)], axis=1)
            said = f"{place}: drives {components}, {way.max():.6g} m at the end"
        lines.append((prescriber.name or prescriber.key, said))
    return lines


def _describe_mass(system: System) -> str:
    scene = system.scene
    parts = [("added", sum(mass.value for mass in scene.mass)), ("hub", 0.0 if scene.hub is None else scene.hub.mass)]
    parts = [f"{mass:g} {name}" for name, mass in parts if mass > 0.0]
    return f"{system.total_mass:.6g} kg" + (f", of which {' and '.join(parts)}" if parts else "")


def _describe_analysis(scene: Scene) -> str:
    analysis = scene.analysis
    if analysis.kind == "dynamic":
        return f"dynamic, {analysis.duration:g} s"
    steps = f"{analysis.load_steps} load steps or more"
    return f"static, {steps}" if analysis.kind == "static" else f"modal, {analysis.count} frequencies after {steps}"


def _describe_stiffness(given: ContactTable, used: ContactTable) -> list[tuple[str, str]]:
    keys = {"sts": ["sts_stiffness"], "nts": ["nts_stiffness"]}.get(used.method, ["sts_stiffness", "nts_stiffness"])
    of = {"sts_stiffness": "N/m^3 of surfaces", "nts_stiffness": "N/m of nodes" + " and edges" * (len(keys) == 2)}
    line = ", ".join(f"{getattr(used, key):.4g} {of[key]}" for key in keys)
    if any(getattr(given, key) == "auto" for key in keys):
        line += f"; for a penetration of {used.target_penetration:g} of the thickness at {used.expected_speed:.4g} m/s"
    return [("contact stiffness", line + ("; never closer than the thickness" if used.exact else ""))]
