"""STUDY.toml: which scene, which values of its keys, and what is read from the runs."""

import re
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, StringConstraints, ValidationError, model_validator

from warp_origami.errors import InputError
from warp_origami.scene.base import AsTuple, Count, Index, Number, Positive, Table, fault
from warp_origami.scene.expected import OF_WANTS
from warp_origami.scene.expression import parse
from warp_origami.scene.faults import input_error
from warp_origami.scene.toml import DEEPEST, read_toml

MOST_RUNS = 10_000
"""In a study."""

KEY = rf"^\w+(\.\w+){{0,{DEEPEST - 1}}}$"
KEY_WANTS = "the path of a key of the scene, for example material.thickness or driver.0.profile.end"
Key = Annotated[str, StringConstraints(pattern=KEY)]
NAME_WANTS = "a name of letters, digits, spaces and _ + - . that can be a folder's, at most 100 characters"
SAMPLING_WANTS = "a table with kind: grid, list or latin_hypercube"


class Grid(Table):
    """Every value of every parameter with every value of the others."""

    kind: Literal["grid"] = Field(description='"grid"')


class List(Table):
    """The first values of all parameters, then the second ones, and so on."""

    kind: Literal["list"] = Field(description='"list"')


class LatinHypercube(Table):
    """As many points as wanted, each parameter evenly covered."""

    kind: Literal["latin_hypercube"] = Field(description='"latin_hypercube"')
    count: Annotated[Count, Field(le=MOST_RUNS)] = Field(
        description=f"an integer from 1 to {MOST_RUNS}: number of points"
    )
    seed: Index = Field(default=0, description="an integer >= 0: the same seed gives the same points")


Sampling = Annotated[Grid | List | LatinHypercube, Field(discriminator="kind")]


class Parameter(Table):
    """A key of the scene and the values it takes: given ones, a range, or a normal distribution."""

    key: Key = Field(description=KEY_WANTS)
    values: Annotated[tuple[Any, ...], AsTuple, Field(min_length=1)] | None = Field(
        default=None, description="a list of values, as the scene file would have them"
    )
    range: Annotated[tuple[Number, Number], AsTuple] | None = Field(
        default=None, description="[low, high] with low < high"
    )
    scale: Literal["linear", "log"] | None = Field(
        default=None, description='"linear" or "log", beside range: how it is divided'
    )
    count: Annotated[Count, Field(ge=2, le=MOST_RUNS)] | None = Field(
        default=None,
        description=f"an integer from 2 to {MOST_RUNS}, beside range: number of values, both ends among them",
    )
    normal: Annotated[tuple[Number, Positive], AsTuple] | None = Field(
        default=None, description="[mean, standard deviation], beside latin_hypercube"
    )
    integer: bool = Field(
        default=False, description="true: values of a range or a distribution are rounded to integers"
    )

    @model_validator(mode="after")
    def _one_source(self):
        given = [key for key in ("values", "range", "normal") if getattr(self, key) is not None]
        if len(given) != 1:
            raise fault("", " and ".join(given) or "no values", "exactly one of values, range, normal")
        for key in ("scale", "count"):
            if self.range is None and getattr(self, key) is not None:
                raise fault(key, getattr(self, key), f"{key} only beside range")
        if self.integer and self.values is not None:
            raise fault("integer", "true", "integer only beside range or normal")
        if self.range is not None:
            low, high = self.range
            if not low < high:
                raise fault("range", list(self.range), "[low, high] with low < high")
            if self.scale == "log" and low <= 0.0:
                raise fault("range", list(self.range), "numbers > 0 where the scale is log")
        return self


def _an_expression(text: str) -> str:
    try:
        paths = parse(text).paths
    except ValueError:
        raise fault("", f'"{text[:60]}"', OF_WANTS) from None
    if "surface.volume" in paths:
        raise fault("", f'"{text[:60]}"', "results that stand in tables: no surface.volume")
    return text


class Result(Table):
    """A number read from every run: an expression over the last rows of its tables, max() and min() over all rows."""

    name: Annotated[str, StringConstraints(pattern=r"^[^,\"\r\n]+$", max_length=100)] = Field(
        description='a name without commas, quotes and line breaks, with its unit if it has one: "tip height (m)"'
    )
    of: Annotated[str, AfterValidator(_an_expression)] = Field(description=OF_WANTS)


class Plot(Table):
    """What is drawn against the parameters."""

    of: Annotated[tuple[str, ...], AsTuple, Field(min_length=1, max_length=6)] | None = Field(
        default=None, description="a list of at most 6 names of results or numbers of the summary [the results]"
    )
    log: bool = Field(default=False, description="true: logarithmic scale of what is drawn")


SUMMARY_COLUMNS = (
    "steps_accepted",
    "steps_rejected",
    "newton_iterations",
    "linear_solves",
    "max_penetration",
    "energy_gain",
    "energy_loss",
    "wall_seconds",
    "peak_memory_bytes",
)
"""Numbers of the summary that stand in the table of every study."""


class Study(Table):
    """Runs of a scene over values of its keys.

    Raises:
        InputError: anything is missing, unknown, out of range or contradictory; one line per fault.
    """

    name: Annotated[str, StringConstraints(pattern=r"^\w[\w +.-]{0,99}$")] = Field(description=NAME_WANTS)
    scene: Annotated[str, Field(min_length=1)] = Field(
        description="name of a bundled scene, or path of a scene file relative to the study's folder"
    )
    until: Positive | None = Field(
        default=None, description="a number > 0, s (static: load factor): end every run there"
    )
    limit: Positive | None = Field(default=None, description="a number > 0, s: wall time that a run may take")
    set: dict[Key, Any] = Field(
        default={}, description="a table of dotted keys of the scene, in quotes, and their values"
    )
    sampling: Sampling = Field(description=SAMPLING_WANTS)
    parameter: Annotated[tuple[Parameter, ...], AsTuple, Field(min_length=1)] = Field(
        description="an array of tables [[parameter]]"
    )
    result: Annotated[tuple[Result, ...], AsTuple] = Field(default=(), description="an array of tables [[result]]")
    plot: Plot = Field(default=Plot(), description="a table")

    def __init__(self, **values: Any):
        try:
            super().__init__(**values)
        except ValidationError as error:
            raise input_error(error, values, type(self)) from None

    @model_validator(mode="after")
    def _consistent(self):
        self._refuse_repeated_names()
        kind = self.sampling.kind
        for k, parameter in enumerate(self.parameter):
            place = f"parameter.{k}"
            if kind == "latin_hypercube" and parameter.count is not None:
                raise fault(f"{place}.count", parameter.count, "count in [sampling] only")
            if kind != "latin_hypercube" and parameter.normal is not None:
                raise fault(
                    f"{place}.normal", list(parameter.normal), 'normal only where sampling.kind is "latin_hypercube"'
                )
            if kind != "latin_hypercube" and parameter.range is not None and parameter.count is None:
                raise fault(f"{place}.count", "nothing", "an integer >= 2: number of values in the range")
        sizes = [len(one.values) if one.values is not None else one.count for one in self.parameter]
        if kind == "list" and len(set(sizes)) > 1:
            raise fault("parameter", f"lists of {', '.join(map(str, sizes))} values", "lists of the same length")
        runs = 1
        for size in sizes if kind == "grid" else ():
            runs *= size
        if kind == "grid" and runs > MOST_RUNS:
            raise fault("parameter", f"a grid of {runs} runs", f"at most {MOST_RUNS}")
        known = {*(one.name for one in self.result), *SUMMARY_COLUMNS}
        for k, name in enumerate(self.plot.of or ()):
            if name not in known and not re.fullmatch(r"frequencies\.\d+", name):
                raise fault(f"plot.of.{k}", f'"{name}"', "one of " + ", ".join(sorted(known)))
        return self

    def _refuse_repeated_names(self) -> None:
        keys = [parameter.key for parameter in self.parameter]
        for k, key in enumerate(keys):
            if key in keys[:k] or key in self.set:
                owner = "set" if key in self.set else f"parameter.{keys.index(key)}"
                raise fault(f"parameter.{k}.key", f'"{key}"', f"a key that nothing else sets ({owner} does)")
        names = [result.name for result in self.result]
        for k, name in enumerate(names):
            if name in names[:k] or name in keys or name in (*SUMMARY_COLUMNS, "run", "folder", "status", "message"):
                raise fault(f"result.{k}.name", f'"{name}"', "a name that no other column of the table has")


def load_study(path: str | Path) -> tuple[Study, Path]:
    """A study, and the folder that its scene's path starts from.

    Raises:
        InputError: it cannot be read or is no valid study.
    """
    path = Path(path)
    if path.suffix != ".toml":
        raise InputError("study", repr(str(path)), "the path of a .toml file")
    return Study(**read_toml(path, "study")), path.parent
