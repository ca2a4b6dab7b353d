"""How it is computed and what is written: analysis, contact, integrator, output, probes."""

from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from .base import NAME_WANTS, AsTuple, Name, Number, Positive, Table, Vector2, fault

FIELDS = ("von_mises", "s1", "s2", "state")
FieldName = Literal["von_mises", "s1", "s2", "state"]


class Analysis(Table):
    """The kind of analysis."""

    kind: Literal["dynamic"] = Field(
        description='"dynamic" (static and modal analyses are not available in this version)'
    )
    duration: Positive = Field(description="a number > 0: simulated time, s")


class Contact(Table):
    """Penalty contact of the sheet with itself."""

    method: Literal["mixed", "sts", "nts"] = Field(default="mixed", description='"mixed", "sts" or "nts"')
    sts_stiffness: Positive = Field(default=1e8, description="a number > 0: surface-to-surface penalty, N/m^3")
    nts_stiffness: Positive = Field(default=3e6, description="a number > 0: node-to-surface penalty, N/m")
    thickness: Positive | None = Field(
        default=None, description="a number > 0, m: layers closer than this touch (unless given: material.thickness)"
    )


class Integrator(Table):
    """Generalized-alpha time integration."""

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
    linear_solver: Literal["auto", "scipy"] = Field(default="auto", description='"auto" or "scipy"')


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
