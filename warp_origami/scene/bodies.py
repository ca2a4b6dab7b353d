"""What is fastened to the sheet: added masses and a rigid hub; and springs along its creases."""

from typing import Annotated, Literal

from pydantic import Field, StringConstraints, model_validator

from .base import NotNegative, Number, Positive, Table, Vector3, fault
from .motion import AT_WANTS, Profile, Selector


class Mass(Table):
    """Mass added to the sheet: a point, a rod along edges, or a patch.

    Spread over what it selects as a force is: the whole sheet evenly over its area; vertices that selected boundary
    edges join, evenly along these edges; else those that whole elements, or edges inside the sheet, join, evenly over
    these; else in equal shares on the vertices.
    """

    at: Selector = Field(description=AT_WANTS)
    value: Positive = Field(description="a number > 0, kg: the total over the selection")


class Hub(Table):
    """A rigid body to which the selected points of the sheet, and the edges between them, are fixed."""

    at: Selector = Field(description=AT_WANTS)
    mass: Positive = Field(description="a number > 0, kg")
    axial_inertia: Positive = Field(
        description="a number > 0, kg m^2: moment of inertia about the axis through the centre"
    )
    transverse_inertia: Positive | None = Field(
        default=None,
        description="a number > axial_inertia / 2, kg m^2: about axes across it (unless given: axial_inertia)",
    )
    axis: Vector3 = Field(default=(0.0, 0.0, 1.0), description="[x, y, z], not zero")
    centre: Vector3 | None = Field(
        default=None, description="[x, y, z], m: centre of mass (unless given: the mean of the points, as they start)"
    )
    mount: Literal["free", "axis", "driven"] = Field(
        default="free", description='"free", "axis" (turns about its axis, which is held) or "driven"'
    )
    angle: Number | None = Field(default=None, description='a number, beside mount = "driven": rad at factor 1')
    profile: Profile | None = Field(default=None, description='a profile, beside mount = "driven"')

    @model_validator(mode="after")
    def _complete(self):
        if not any(self.axis):
            raise fault("axis", list(self.axis), "[x, y, z], not zero")
        if self.transverse_inertia is None:
            object.__setattr__(self, "transverse_inertia", self.axial_inertia)
        if self.transverse_inertia <= 0.5 * self.axial_inertia:
            wants = f"more than axial_inertia / 2 = {0.5 * self.axial_inertia:g}: a body is not thinner than a disc"
            raise fault("transverse_inertia", self.transverse_inertia, wants)
        for key in ("angle", "profile"):
            if self.mount != "driven" and getattr(self, key) is not None:
                raise fault(key, key, f'no {key} beside mount = "{self.mount}"')
        if self.mount == "driven" and self.angle is None:
            raise fault("angle", "nothing", "a number: angle at factor 1, rad")
        return self


CreaseLetters = Annotated[str, StringConstraints(pattern=r"^[MVU]+$")]


class CreaseSpring(Table):
    """A rotational spring along creases, per length of crease; those of several tables add up.

    Fold angles are those of FOLD: 0 flat, positive for a valley, negative for a mountain, seen from +z of the flat
    sheet.
    """

    stiffness: NotNegative = Field(description="a number >= 0: moment per angle and length, N m/rad per m")
    rest_angle: Literal["stowed"] | Number = Field(
        default=0.0,
        description='a number, rad: the fold angle without moment, or "stowed": that of the stowed state '
        "(of a FOLD file: edges_foldAngle)",
    )
    assignment: CreaseLetters = Field(default="MVU", description="some of the letters M, V, U: creases that have it")
    at: Selector = Field(
        default=Selector(all=True), description=AT_WANTS + "; a crease has it whose two ends are selected"
    )
