"""What pushes the sheet: gravity, pressure, sunlight, forces, initial velocity and spin."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

from .base import Number, Positive, Table, Vector3, fault
from .motion import AT_WANTS, Profile, Selector

PROFILE_WANTS = "a profile (unless given: constant; in statics the load factor)"


class Gravity(Table):
    """A uniform acceleration of the whole sheet, times the profile."""

    kind: Literal["gravity"] = Field(description='"gravity"')
    acceleration: Vector3 = Field(description="[x, y, z], m/s^2")
    profile: Profile | None = Field(default=None, description=PROFILE_WANTS)


class Pressure(Table):
    """Pressure on the elements whose corners are all selected, positive along r_x x r_y, times the profile.

    A follower pressure stays normal to the deformed sheet and acts on its present area; a dead one keeps the direction
    of the normal of the initial state and acts per area of the flat sheet.
    """

    kind: Literal["pressure"] = Field(description='"pressure"')
    value: Number = Field(description="a number, Pa")
    follower: bool = Field(default=True, description="true or false (dead pressure)")
    at: Selector = Field(default=Selector(all=True), description=AT_WANTS)
    profile: Profile | None = Field(default=None, description=PROFILE_WANTS)


class Force(Table):
    """A force of fixed direction, spread over what it selects, times the profile.

    The whole sheet: evenly over its area. Vertices that selected boundary edges join: evenly along these edges; else
    those that whole elements, or edges inside the sheet, join: evenly over these; else in equal shares on the vertices.
    """

    kind: Literal["force"] = Field(description='"force"')
    value: Vector3 = Field(description="[x, y, z], N: the total over the selection")
    at: Selector = Field(default=Selector(all=True), description=AT_WANTS)
    profile: Profile | None = Field(default=None, description=PROFILE_WANTS)


class InitialVelocity(Table):
    """Velocity at the start of what it selects."""

    kind: Literal["initial_velocity"] = Field(description='"initial_velocity"')
    value: Vector3 = Field(description="[x, y, z], m/s")
    at: Selector = Field(default=Selector(all=True), description=AT_WANTS)


class InitialSpin(Table):
    """Rotation at the start of what it selects, with all that is fastened to it; of everything: the hub too."""

    kind: Literal["initial_spin"] = Field(description='"initial_spin"')
    rate: Number = Field(
        description="a number, rad/s: positive turns counter-clockwise seen from where the axis points"
    )
    axis: Vector3 = Field(default=(0.0, 0.0, 1.0), description="[x, y, z], not zero")
    centre: Vector3 = Field(default=(0.0, 0.0, 0.0), description="[x, y, z], m")
    at: Selector = Field(default=Selector(all=True), description=AT_WANTS)

    @model_validator(mode="after")
    def _axis_not_zero(self):
        if not any(self.axis):
            raise fault("axis", list(self.axis), "[x, y, z], not zero")
        return self


Share = Annotated[Number, Field(ge=0.0, le=1.0)]


class Optics(Table):
    """How one side of the sheet meets light; by default an ideal mirror."""

    reflectivity: Share = Field(default=1.0, description="a number from 0 to 1: share of the light that is reflected")
    specular: Share = Field(
        default=1.0, description="a number from 0 to 1: share of the reflected light that is reflected as by a mirror"
    )
    emissivity: Share = Field(default=0.0, description="a number from 0 to 1: of heat radiation")
    lambertian: Share = Field(
        default=2.0 / 3.0,
        description="a number from 0 to 1: coefficient B of diffuse and heat radiation (2/3: Lambertian)",
    )


PRESSURE_AT_1_AU = 4.56e-6
"""Pa, solar flux over the speed of light at the distance of the earth (McInnes 1999)."""


class Sunlight(Table):
    """Solar radiation pressure on the elements whose corners are all selected, on whichever side is lit, times the
    profile; nothing shades anything."""

    kind: Literal["solar"] = Field(description='"solar"')
    direction: Vector3 = Field(description="[x, y, z], not zero: where the light goes")
    value: Positive = Field(
        default=PRESSURE_AT_1_AU, description="a number > 0, Pa: energy flux over the speed of light (4.56e-6 at 1 au)"
    )
    front: Optics = Field(default=Optics(), description="a table: the side from which the flat sheet is seen from +z")
    back: Optics | None = Field(default=None, description="a table: the other side (unless given: as the front)")
    at: Selector = Field(default=Selector(all=True), description=AT_WANTS)
    profile: Profile | None = Field(default=None, description=PROFILE_WANTS)

    @model_validator(mode="after")
    def _complete(self):
        if not any(self.direction):
            raise fault("direction", list(self.direction), "[x, y, z], not zero")
        if self.back is None:
            object.__setattr__(self, "back", self.front)
        return self


Load = Annotated[Gravity | Pressure | Force | InitialVelocity | InitialSpin | Sunlight, Field(discriminator="kind")]
