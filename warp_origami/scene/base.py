"""Tables and value types of the scene file."""

from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, StringConstraints
from pydantic_core import PydanticCustomError


class Table(BaseModel):
    """A table of the scene file: immutable, every key known, no conversion between types (an integer is a number).

    The description of a field says what is wanted there and ends up in messages.
    """

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False)

    def __init__(self, **values: Any):
        super().__init__(**values)


def fault(key: str, got: object, wants: str) -> PydanticCustomError:
    """What a validator raises when the values of a table do not fit together; `key` is relative to the table."""
    return PydanticCustomError("fault", "{key}: got {got}, wants {wants}", {"key": key, "got": got, "wants": wants})


def _plain(value: Any) -> Any:
    """NumPy numbers and arrays, which scenes written in Python may hold, as Python numbers and lists."""
    return value.tolist() if hasattr(value, "tolist") else value


def _as_tuple(value: Any) -> Any:
    value = _plain(value)
    return tuple(_as_tuple(item) for item in value) if isinstance(value, list | tuple) else value


LARGEST_NUMBER, LARGEST_COUNT = 1e30, 10_000_000
"""Beyond these nothing is modelled: products of numbers would not be numbers any more. A number is 0 or its inverse is
within the limit too."""


def _within(value: float) -> float:
    if abs(value) > LARGEST_NUMBER or 0.0 < abs(value) < 1.0 / LARGEST_NUMBER:
        wants = f"0, or a size from {1.0 / LARGEST_NUMBER:g} to {LARGEST_NUMBER:g} (in SI units)"
        raise fault("", value, wants)
    return value


def _countable(value: int) -> int:
    if value > LARGEST_COUNT:
        got = value if value < 10**20 else f"an integer of {value.bit_length()} bits"
        raise fault("", got, f"at most {LARGEST_COUNT}")
    return value


Number = Annotated[float, BeforeValidator(_plain), AfterValidator(_within)]
Positive = Annotated[float, Field(gt=0.0), BeforeValidator(_plain), AfterValidator(_within)]
NotNegative = Annotated[float, Field(ge=0.0), BeforeValidator(_plain), AfterValidator(_within)]
Count = Annotated[int, Field(ge=1), BeforeValidator(_plain), AfterValidator(_countable)]
Index = Annotated[int, Field(ge=0), BeforeValidator(_plain), AfterValidator(_countable)]

AsTuple = BeforeValidator(_as_tuple)
"""Lets arrays of the file and of NumPy stand where the scene holds tuples."""

Vector2 = Annotated[tuple[Number, Number], AsTuple]
Vector3 = Annotated[tuple[Number, Number, Number], AsTuple]

Name = Annotated[str, StringConstraints(pattern=r"^\w[\w-]*$", max_length=100)]
"""A name that can be part of a column heading."""
NAME_WANTS = "a name of letters, digits, '_' and '-', at most 100 characters"


def _ordered_components(value: Any) -> Any:
    known = isinstance(value, str) and value != "" and set(value) <= set("xyz") and len(set(value)) == len(value)
    if not known:
        raise PydanticCustomError("components", "not a set of components")
    return "".join(sorted(value))


Components = Annotated[str, BeforeValidator(_ordered_components)]
COMPONENTS_WANTS = "some of the letters x, y, z, each at most once"
