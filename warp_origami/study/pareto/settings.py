"""Which settings of a scene are worth comparing: one kind at a time around the scene's own, and a few combinations."""

from dataclasses import dataclass, replace

from warp_origami.scene import Scene

TOLERANCES = (64.0, 16.0, 4.0, 2.0, 0.5, 0.25, 0.125)
"""Over the scene's own; the last two are the pair whose agreement tells how far a motion can be compared."""

STEPS = (8.0, 4.0, 2.0, 0.5, 0.25, 0.125)
"""The same for a scene with a fixed step."""

RADII = (0.0, 0.15, 0.3, 0.5, 0.7, 0.9)
COMBINED_RADII = (0.0, 0.6)
DEGREES = (2, 4, 5, 6, 8)
METHODS = ("mixed", "sts", "nts")
FORMS = ("eliminate", "multipliers")
LOAD_STEPS = (1, 5, 20, 80)
AUTOMATIC = "integrator.step=auto"
REFINEMENTS = (2, 3, 4)
COARSENED = 8
"""Cells of a sheet, each way, from which on half as many are tried: their vertices must tell the motion."""

COMBINED_FACTORS = (16.0, 4.0, 0.25)
"""Of the tolerance or step, in combination with another setting."""


@dataclass(frozen=True)
class Setting:
    """One choice of settings.

    Attributes:
        label: what differs from the scene's own; different for every setting.
        varied: what kind of setting that is.
        changes: to the scene, as of load_scene, beside those of the mesh.
        mesh: changes that make the mesh.
        fineness: the scene's own tolerance or step over that of the setting.
    """

    label: str
    varied: str
    changes: tuple[str, ...] = ()
    mesh: tuple[str, ...] = ()
    fineness: float = 1.0

    @property
    def only_steps(self) -> bool:
        """Whether nothing but the mesh, and the tolerance or step, differs from the scene's own."""
        steps = ("integrator.tolerance=", "integrator.step=")
        return all(change.startswith(steps) and change != AUTOMATIC for change in self.changes)

    def on(self, mesh: "Setting") -> "Setting":
        """The same on another mesh."""
        varied = f"{mesh.varied} and {self.varied}"
        return replace(self, label=f"{mesh.label}, {self.label}", varied=varied, mesh=mesh.mesh)


OWN = Setting("the scene's own", "none")
AGAIN = Setting("the scene's own again", "none")
"""Tells how much two measurements of the same differ."""


def stepping_ladder(scene: Scene) -> list[Setting]:
    """Coarse to fine: tolerances of a dynamic scene, or steps where the scene fixes them; without the scene's own."""
    if scene.integrator.step == "auto":
        return [_stepping(scene, factor) for factor in TOLERANCES]
    return [_stepping(scene, factor) for factor in STEPS]


def _stepping(scene: Scene, factor: float) -> Setting:
    key = "tolerance" if scene.integrator.step == "auto" else "step"
    value = float(f"{factor * getattr(scene.integrator, key):.6g}")
    return Setting(f"{key} {value:.3g}", key, (f"integrator.{key}={value!r}",), fineness=1.0 / factor)


def other_settings(scene: Scene) -> list[Setting]:
    """What can be varied on the scene's own mesh beside tolerance and step, most interesting first."""
    dynamic = scene.analysis.kind == "dynamic"
    found = _radii(scene) if dynamic else _load_steps(scene)
    for degree in DEGREES if scene.integrator.elements == "cubic" else ():
        if degree != scene.integrator.quadrature:
            found.append(Setting(f"quadrature {degree}", "quadrature", (f"integrator.quadrature={degree}",)))
    found += contact_methods(scene)
    for form in FORMS:
        if form != scene.integrator.constraints:
            found.append(Setting(form, "constraints", (f"integrator.constraints={form}",)))
    return found + (_radii_and_steps(scene) if dynamic else [])


def contact_methods(scene: Scene) -> list[Setting]:
    """The other methods, for a scene with contact."""
    if scene.contact is None:
        return []
    others = [method for method in METHODS if method != scene.contact.method]
    return [Setting(f"contact {method}", "contact", (f"contact.method={method}",)) for method in others]


def _radii(scene: Scene) -> list[Setting]:
    found = []
    for radius in RADII:
        if radius != scene.integrator.spectral_radius:
            found.append(_radius(radius))
    if scene.integrator.step != "auto":
        found.append(Setting("automatic step", "automatic step", (AUTOMATIC,)))
    return found


def _radii_and_steps(scene: Scene) -> list[Setting]:
    radii = [radius for radius in COMBINED_RADII if radius != scene.integrator.spectral_radius]
    steps = [_stepping(scene, factor) for factor in (COMBINED_FACTORS[0], COMBINED_FACTORS[-1])]
    return [_radius(radius, stepping) for stepping in steps for radius in radii]


def _radius(radius: float, stepping: Setting | None = None) -> Setting:
    label, change = f"radius {radius:g}", f"integrator.spectral_radius={radius!r}"
    if stepping is None:
        return Setting(label, "spectral radius", (change,))
    varied = f"spectral radius and {stepping.varied}"
    return Setting(f"{label}, {stepping.label}", varied, (change, *stepping.changes), fineness=stepping.fineness)


def _load_steps(scene: Scene) -> list[Setting]:
    own = scene.analysis.load_steps
    return [Setting(f"load steps {n}", "load steps", (f"analysis.load_steps={n}",)) for n in LOAD_STEPS if n != own]


def meshes(scene: Scene) -> list[Setting]:
    """Other meshes of the scene, coarse to fine: those of its [verification], else its pattern refined."""
    if scene.verification is not None and len(scene.verification.refinement) > 1:
        return [
            Setting(_short(changes), "mesh", mesh=tuple(changes))
            for changes in scene.verification.refinement
            if changes
        ]
    own = scene.pattern.refine
    found = [_refined(own * factor) for factor in REFINEMENTS]
    pattern = scene.pattern
    if pattern.kind == "sheet" and own == 1 and not pattern.creases_x and not pattern.creases_y:
        if min(pattern.nx, pattern.ny) >= COARSENED and pattern.nx % 2 == pattern.ny % 2 == 0:
            nx, ny = pattern.nx // 2, pattern.ny // 2
            found.insert(0, Setting(f"{nx} x {ny} cells", "mesh", mesh=(f"pattern.nx={nx}", f"pattern.ny={ny}")))
    return found


def _refined(n: int) -> Setting:
    return Setting(f"refine {n}", "mesh", mesh=(f"pattern.refine={n}",))


def _short(changes: tuple[str, ...]) -> str:
    return ", ".join(change.removeprefix("pattern.").replace("=", " ") for change in changes)


def on_meshes(scene: Scene, mesh: Setting) -> list[Setting]:
    """Settings in combination with another mesh."""
    if scene.analysis.kind == "dynamic":
        return [_stepping(scene, factor).on(mesh) for factor in COMBINED_FACTORS]
    degrees = [setting for setting in other_settings(scene) if setting.varied == "quadrature"]
    return [setting.on(mesh) for setting in degrees]
