"""What a scene is known to give: exact values, and the meshes on which their errors are followed."""

from typing import Annotated

from pydantic import AfterValidator, Field, field_validator

from .base import AsTuple, Number, Positive, Table, fault

OF_WANTS = (
    "a result: frequencies.N, history.COLUMN, probes.NAME.COLUMN or reactions.NAME.COLUMN, "
    "columns as in the tables of results"
)


def _a_result(path: str) -> str:
    parts = path.split(".")
    lengths = {"frequencies": 2, "history": 2, "probes": 3, "reactions": 3}
    if lengths.get(parts[0]) != len(parts) or not all(parts):
        raise fault("", f'"{path}"', OF_WANTS)
    return path


class Value(Table):
    """A value that the last row of a table of results is held against."""

    name: str = Field(min_length=1, description="a name, with its unit if it has one")
    of: Annotated[str, AfterValidator(_a_result)] = Field(description=OF_WANTS)
    over: Number = Field(default=1.0, description="a number, not 0: the result is divided by it")
    exact: Number = Field(description="a number: the exact value of the result over `over`")
    tolerance: Positive = Field(description="a number > 0: largest relative error (absolute where exact is 0)")

    @field_validator("over")
    @classmethod
    def _not_zero(cls, over: float) -> float:
        if over == 0.0:
            raise fault("", over, "a number, not 0")
        return over


class Verification(Table):
    """Exact values of a scene's results, their source, and meshes from coarse to fine."""

    source: str = Field(min_length=1, description="where the exact values come from")
    refinement: Annotated[tuple[tuple[str, ...], ...], AsTuple] = Field(
        default=((),),
        min_length=1,
        description='a list of meshes, coarse to fine, each a list of changes to the scene: ["pattern.nx=4", ...]',
    )
    value: Annotated[tuple[Value, ...], AsTuple] = Field(min_length=1, description="an array of tables")
