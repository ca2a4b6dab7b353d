"""How it is computed and what is written: analysis, contact, integrator, output, probes."""

from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from .base import NAME_WANTS, AsTuple, Count, Name, NotNegative, Number, Positive, Table, Vector2, fault

FIELDS = ("von_mises", "s1", "s2", "state", "contact_pressure")
FieldName = Literal["von_mises", "s1", "s2", "state", "contact_pressure"]


class Dynamic(Table):
    """Motion in time."""

    kind: Literal["dynamic"] = Field(description='"dynamic"')
    duration: Positive = Field(description="a number > 0: simulated time, s")

    @property
    def end(self) -> float:
        """Where the run ends, s."""
        return self.duration


LOAD_STEPS_WANTS = "an integer >= 1 and <= 100000: load steps, more where they are needed"
LoadSteps = Annotated[Count, Field(le=100_000)]


class Static(Table):
    """Equilibrium under loads and prescribed displacements that grow with a load factor from 0 to 1.

    The load factor takes the place of time: in profiles, tables of results and frames.
    """

    kind: Literal["static"] = Field(description='"static"')
    load_steps: LoadSteps = Field(default=20, description=LOAD_STEPS_WANTS)

    @property
    def end(self) -> float:
        """The load factor at the end."""
        return 1.0


class Modal(Table):
    """Small free vibrations about the static solution under the loads."""

    kind: Literal["modal"] = Field(description='"modal"')
    count: Annotated[Count, Field(le=10_000)] = Field(
        default=12, description="an integer >= 1 and <= 10000: number of frequencies, from the lowest"
    )
    load_steps: LoadSteps = Field(default=20, description=LOAD_STEPS_WANTS)

    @property
    def end(self) -> float:
        """The load factor at the end of the static solution."""
        return 1.0


Analysis = Annotated[Dynamic | Static | Modal, Field(discriminator="kind")]


class Contact(Table):
    """Penalty contact of the sheet with itself."""

    method: Literal["mixed", "sts", "nts"] = Field(default="mixed", description='"mixed", "sts" or "nts"')
    sts_stiffness: Literal["auto"] | Positive = Field(
        default=1e8, description='"auto" or a number > 0: surface-to-surface penalty, N/m^3'
    )
    nts_stiffness: Literal["auto"] | Positive = Field(
        default=3e6, description='"auto" or a number > 0: node-to-surface and edge-to-edge penalty, N/m'
    )
    target_penetration: Annotated[Positive, Field(le=0.5)] = Field(
        default=0.01, description='a number > 0 and <= 0.5: penetration over the thickness that "auto" is to allow'
    )
    expected_speed: Literal["auto"] | NotNegative = Field(
        default="auto", description='"auto" or a number >= 0, m/s: speed at which layers meet, for stiffness "auto"'
    )
    thickness: Positive | None = Field(
        default=None, description="a number > 0, m: layers closer than this touch (unless given: material.thickness)"
    )
    exact: bool = Field(
        default=False, description="true: layers never come closer than the thickness; false: they press into it"
    )
    friction: Annotated[Number, Field(ge=0.0)] = Field(
        default=0.0, description="a number >= 0: coefficient of Coulomb friction between layers"
    )
    friction_speed: Positive = Field(
        default=1e-3,
        description="a number > 0, m/s: layers that stick creep up to about this fast, small against what moves them",
    )


class Integrator(Table):
    """Integration in time (generalized-alpha) and over the elements."""

    spectral_radius: Annotated[Number, Field(ge=0.0, le=1.0)] = Field(
        default=0.3, description="a number from 0 (most damping of high frequencies) to 1 (none)"
    )
    tolerance: Positive = Field(
        default=1e-4, description="a number > 0: local error per step over the size of the sheet"
    )
    step: Literal["auto"] | Positive = Field(default="auto", description='"auto" or a number > 0: fixed step, s')
    constraints: Literal["eliminate", "multipliers"] = Field(
        default="eliminate", description='"eliminate" or "multipliers"'
    )
    quadrature: Annotated[Count, Field(le=8)] = Field(
        default=6, description="an integer from 1 to 8: degree of the polynomials that cubic elements integrate exactly"
    )
    elements: Literal["cubic", "linear"] = Field(
        default="cubic",
        description='"cubic" (the paper\'s) or "linear": plane triangles, along all of whose edges the sheet may fold',
    )
    linear_solver: Literal["auto", "scipy", "pardiso", "cudss"] = Field(
        default="auto", description='"auto", "scipy", "pardiso" (extra "fast") or "cudss" (extra "cuda")'
    )


def _no_repeats(values: tuple[str, ...]) -> tuple[str, ...]:
    for name in values:
        if values.count(name) > 1:
            raise fault("", f'"{name}" twice', "each field once")
    return values


class Output(Table):
    """Frames of the animation and the fields drawn on it."""

    fps: Literal["steps"] | Positive = Field(
        default=60.0, description='a number > 0: frames per simulated second, or "steps": every accepted step'
    )
    fields: Annotated[tuple[FieldName, ...], AsTuple, AfterValidator(_no_repeats)] = Field(
        default=("von_mises", "state"), description="a list of different ones of " + ", ".join(FIELDS)
    )


class Probe(Table):
    """A point of the flat sheet whose motion and stress are recorded."""

    name: Name | None = Field(default=None, description=NAME_WANTS)
    at: Vector2 = Field(description="[x, y], m: a point of the flat sheet")
