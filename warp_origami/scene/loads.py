"""What pushes the sheet: gravity, pressure, forces, initial velocity."""

from typing import Annotated, Literal

from pydantic import Field

from .base import Number, Table, Vector3
from .motion import AT_WANTS, Profile, Selector

PROFILE_WANTS = "a profile, for example of kind constant"


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


Load = Annotated[Gravity | Pressure | Force | InitialVelocity, Field(discriminator="kind")]
