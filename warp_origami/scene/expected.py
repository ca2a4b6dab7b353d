"""What a scene is known to give: exact values, and the meshes on which their errors are followed."""

from typing import Annotated

from pydantic import AfterValidator, Field, field_validator, model_validator

from .base import AsTuple, Count, Number, Positive, Table, fault
from .expression import LONGEST, parse

OF_WANTS = (
    "a result, or numbers and results joined by + - * / ** ( ) max() min(): frequencies.N (from 0), "
    "history.COLUMN, spin.COLUMN, "
    "probes.NAME.COLUMN or reactions.NAME.COLUMN, columns as in the tables of results; surface.volume (over z = 0, "
    f"m^3); at most {LONGEST} characters"
)
TOLERANCE_WANTS = (
    "a number > 0: largest relative error (absolute where exact is 0) on the finest mesh, "
    "or a list of numbers > 0, one for each mesh"
)


def _an_expression(text: str) -> str:
    try:
        parse(text)
    except ValueError:
        got = f'"{text}"' if len(text) <= LONGEST else f"{len(text)} characters"
        raise fault("", got, OF_WANTS) from None
    return text


class Value(Table):
    """A value that the results of a run are held against: what `of` is in their last row."""

    name: str = Field(min_length=1, description="a name, with its unit if it has one")
    of: Annotated[str, AfterValidator(_an_expression)] = Field(description=OF_WANTS)
    over: Number = Field(default=1.0, description="a number, not 0: the result is divided by it")
    exact: Number = Field(description="a number: the exact value of the result over `over`")
    tolerance: Positive | Annotated[tuple[Positive, ...], AsTuple, Field(min_length=1)] = Field(
        description=TOLERANCE_WANTS
    )

    @field_validator("over")
    @classmethod
    def _not_zero(cls, over: float) -> float:
        if over == 0.0:
            raise fault("", over, "a number, not 0")
        return over

    def tolerances(self, meshes: int) -> tuple[float | None, ...]:
        """Largest error on each of so many meshes, None where none is stated."""
        if isinstance(self.tolerance, tuple):
            return self.tolerance
        return (*(None,) * (meshes - 1), self.tolerance)


class Verification(Table):
    """Exact values of a scene's results, their source, and meshes from coarse to fine."""

    source: str = Field(min_length=1, description="where the exact values come from")
    refinement: Annotated[tuple[tuple[str, ...], ...], AsTuple] = Field(
        default=((),),
        min_length=1,
        description='a list of meshes, coarse to fine, each a list of changes to the scene: ["pattern.nx=4", ...]',
    )
    quick: Count | None = Field(
        default=None,
        description="an integer up to the number of meshes: those of a quick check (unless given: all but the last)",
    )
    value: Annotated[tuple[Value, ...], AsTuple] = Field(min_length=1, description="an array of tables")

    @model_validator(mode="after")
    def _complete(self):
        meshes = len(self.refinement)
        if self.quick is None:
            object.__setattr__(self, "quick", max(1, meshes - 1))
        if self.quick > meshes:
            raise fault("quick", self.quick, f"at most the {meshes} meshes of refinement")
        for k, value in enumerate(self.value):
            if len(value.tolerances(meshes)) != meshes:
                got = f"{len(value.tolerance)} numbers"
                raise fault(f"value.{k}.tolerance", got, f"one number, or {meshes}: one for each mesh of refinement")
            if value.name in [other.name for other in self.value[:k]]:
                raise fault(f"value.{k}.name", f'"{value.name}"', "a name that no other value has")
        return self
