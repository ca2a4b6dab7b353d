"""What is held and what is moved: selectors, profiles, supports, drivers."""

from itertools import pairwise
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, model_validator

from warp_origami.model.profile import Profile as ProfileFactor

from .base import (
    COMPONENTS_WANTS,
    NAME_WANTS,
    AsTuple,
    Components,
    Index,
    Name,
    Number,
    Positive,
    Table,
    Vector2,
    Vector3,
    fault,
)

SELECTOR_KINDS = ("near", "box", "circle", "boundary", "all", "vertices")
AT_WANTS = "a selector: a table with one of " + ", ".join(SELECTOR_KINDS)


class Selector(Table):
    """Points of the flat sheet, by exactly one of the keys (`tol` goes with `circle`)."""

    near: Vector2 | None = Field(default=None, description="[x, y], m: the closest vertex is selected")
    box: Annotated[tuple[Vector2, Vector2], AsTuple] | None = Field(
        default=None, description="[[x0, y0], [x1, y1]], m, with x0 <= x1 and y0 <= y1"
    )
    circle: Annotated[tuple[Number, Number, Positive], AsTuple] | None = Field(
        default=None, description="[cx, cy, radius], m, radius > 0"
    )
    tol: Positive | None = Field(
        default=None, description="a number > 0, m: distance from the circle that counts (unless given: 1e-6)"
    )
    boundary: Literal[True] | None = Field(default=None, description="true")
    all: Literal[True] | None = Field(default=None, description="true")
    vertices: Annotated[tuple[Index, ...], AsTuple, Field(min_length=1)] | None = Field(
        default=None, description="a list of vertex numbers >= 0 of the pattern"
    )

    @property
    def kind(self) -> str:
        """Which of the keys selects."""
        return next(kind for kind in SELECTOR_KINDS if getattr(self, kind) is not None)

    @model_validator(mode="after")
    def _one_kind(self):
        kinds = [kind for kind in SELECTOR_KINDS if getattr(self, kind) is not None]
        if len(kinds) != 1:
            raise fault("", ", ".join(kinds) or "an empty table", "exactly one of " + ", ".join(SELECTOR_KINDS))
        if self.tol is not None and self.circle is None:
            raise fault("tol", self.tol, "tol only beside circle")
        if self.circle is not None and self.tol is None:
            object.__setattr__(self, "tol", 1e-6)
        if self.box is not None and any(low > high for low, high in zip(*self.box, strict=True)):
            raise fault("box", [list(corner) for corner in self.box], "[[x0, y0], [x1, y1]], x0 <= x1 and y0 <= y1")
        return self


PROFILE_WANTS = '"linear", "smooth", "trapezoid" or "table" (for loads also "constant")'


class Profile(Table):
    """A factor over time (static: over the load factor): from 0 at `start` to 1 at `end`, or straight lines through the
    rows of `table`."""

    kind: Literal["constant", "linear", "smooth", "trapezoid", "table"] = Field(
        default="smooth", description=PROFILE_WANTS
    )
    start: Number | None = Field(
        default=None, description="a number, s: from here on the factor grows from 0 (unless given: 0)"
    )
    end: Number | None = Field(
        default=None,
        description="a number, s, after start: from here on the factor is 1 (unless given: the end of the run)",
    )
    table: Annotated[tuple[tuple[Number, Number], ...], AsTuple] | None = Field(
        default=None, description="two or more rows [time in s, factor], times increasing"
    )

    @model_validator(mode="before")
    @classmethod
    def _kind_of_table(cls, values: Any) -> Any:
        if isinstance(values, dict) and "table" in values and "kind" not in values:
            return {**values, "kind": "table"}
        return values

    @model_validator(mode="after")
    def _consistent(self):
        ramp = self.kind in ("linear", "smooth", "trapezoid")
        for key in ("start", "end"):
            if not ramp and getattr(self, key) is not None:
                raise fault(key, getattr(self, key), f'no {key} beside kind = "{self.kind}"')
        if self.kind != "table" and self.table is not None:
            raise fault("table", "a table", f'no table beside kind = "{self.kind}"')
        if self.kind == "table":
            times = [row[0] for row in self.table or ()]
            if len(times) < 2 or any(b <= a for a, b in pairwise(times)):
                raise fault("table", f"times {times}", "two or more rows [time in s, factor], times increasing")
        if ramp and self.start is None:
            object.__setattr__(self, "start", 0.0)
        return self

    def completed(self, duration: float) -> "Profile":
        """The profile with its end at the end of the run unless it has one.

        Raises:
            PydanticCustomError: it would end before it starts.
        """
        if self.start is None:
            return self
        end = duration if self.end is None else self.end
        if end <= self.start:
            raise fault("start" if self.end is None else "end", f"start {self.start}, end {end}", "start before end")
        return self.model_copy(update={"end": end})

    def factor(self) -> ProfileFactor:
        """The factor as a function of time (completed profiles only)."""
        if self.kind == "table":
            return ProfileFactor("table", table=np.array(self.table))
        if self.kind == "constant":
            return ProfileFactor("constant")
        return ProfileFactor(self.kind, self.start, self.end)


class Support(Table):
    """Holds components of what it selects where the initial state has them."""

    name: Name | None = Field(default=None, description=NAME_WANTS)
    at: Selector = Field(description=AT_WANTS)
    fix: Components = Field(default="xyz", description=COMPONENTS_WANTS)


class Rotate(Table):
    """Rotation about an axis through a point."""

    axis: Vector3 = Field(description="[x, y, z], not zero")
    centre: Vector3 = Field(default=(0.0, 0.0, 0.0), description="[x, y, z], m")
    angle: Number = Field(description="a number: angle at factor 1, rad")

    @model_validator(mode="after")
    def _axis_not_zero(self):
        if not any(self.axis):
            raise fault("axis", list(self.axis), "[x, y, z], not zero")
        return self


class Driver(Table):
    """Prescribed motion of what it selects, relative to the initial state: rotation first, then translation."""

    name: Name | None = Field(default=None, description=NAME_WANTS)
    at: Selector = Field(description=AT_WANTS)
    translate: Vector3 | None = Field(default=None, description="[x, y, z], m")
    rotate: Rotate | None = Field(default=None, description="a table with axis, centre and angle (rad)")
    translate_to: Literal["deployed"] | None = Field(default=None, description='"deployed"')
    overstretch: Annotated[Number, Field(gt=-1.0)] | None = Field(
        default=None, description="a number > -1, beside translate_to: the flat sheet is scaled by 1 + overstretch"
    )
    axes: Components = Field(default="xyz", description=COMPONENTS_WANTS)
    profile: Profile | None = Field(
        default=None,
        description="a profile: a table with kind, start, end, or with table (unless given: smooth over the run)",
    )

    @model_validator(mode="after")
    def _one_motion(self):
        if self.translate_to is not None:
            for key in ("translate", "rotate"):
                if getattr(self, key) is not None:
                    raise fault(key, f"{key} beside translate_to", "either translate_to, or translate and rotate")
            if self.overstretch is None:
                object.__setattr__(self, "overstretch", 0.0)
            return self
        if self.overstretch is not None:
            raise fault("overstretch", self.overstretch, 'overstretch only beside translate_to = "deployed"')
        if self.translate is None and self.rotate is None:
            raise fault("", "no motion", "translate, rotate or translate_to (to hold without motion: a [[support]])")
        if self.translate is None:
            object.__setattr__(self, "translate", (0.0, 0.0, 0.0))
        return self
