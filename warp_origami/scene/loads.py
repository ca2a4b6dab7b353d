"""What pushes the sheet: gravity and initial velocity."""

from typing import Annotated, Literal

from pydantic import Field

from .base import Table, Vector3
from .motion import AT_WANTS, Profile, Selector


class Gravity(Table):
    """A uniform acceleration of the whole sheet, times the profile."""

    kind: Literal["gravity"] = Field(description='"gravity"')
    acceleration: Vector3 = Field(description="[x, y, z], m/s^2")
    profile: Profile = Field(default=Profile(kind="constant"), description="a profile, for example of kind constant")


class InitialVelocity(Table):
    """Velocity at the start of what it selects."""

    kind: Literal["initial_velocity"] = Field(description='"initial_velocity"')
    value: Vector3 = Field(description="[x, y, z], m/s")
    at: Selector = Field(default=Selector(all=True), description=AT_WANTS)


Load = Annotated[Gravity | InitialVelocity, Field(discriminator="kind")]
