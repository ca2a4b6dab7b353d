"""The scene: everything a user asks for, validated as a whole."""

import re
from pathlib import Path
from typing import Annotated, Any

import tomli_w
from pydantic import Field, ValidationError, model_validator
from pydantic_core import PydanticCustomError

from .base import AsTuple, Table, fault
from .bodies import CreaseSpring, Hub, Mass
from .expected import Verification
from .faults import input_error, show
from .loads import Load
from .motion import Driver, Profile, Support
from .settings import Analysis, Contact, Integrator, Output, Probe
from .sheet import Material, Pattern

MOST_FRAMES, MOST_STEPS = 1_000_000, 100_000_000
"""Of a run."""


class Scene(Table):
    """A simulation, with the fields of the scene file; SI units throughout.

    Every default is filled in. `support`, `driver`, `load` and `probe` are tuples, as the file's arrays of tables.

    Raises:
        InputError: anything is missing, unknown, out of range or contradictory; one line per fault.
    """

    name: str = Field(
        description="a name of letters, digits, spaces and _ + - . that can be a folder's, at most 100 characters"
    )
    analysis: Analysis = Field(description="a table with kind: dynamic, static or modal")
    pattern: Pattern = Field(description="a table with kind and the parameters of that kind")
    material: Material = Field(description="a table with density, youngs_modulus, poisson_ratio, thickness")
    contact: Contact | None = Field(default=None, description="a table; without it there is no contact")
    support: Annotated[tuple[Support, ...], AsTuple] = Field(default=(), description="an array of tables [[support]]")
    driver: Annotated[tuple[Driver, ...], AsTuple] = Field(default=(), description="an array of tables [[driver]]")
    crease: Annotated[tuple[CreaseSpring, ...], AsTuple] = Field(
        default=(), description="an array of tables [[crease]]: springs along creases"
    )
    mass: Annotated[tuple[Mass, ...], AsTuple] = Field(default=(), description="an array of tables [[mass]]")
    hub: Hub | None = Field(default=None, description="a table; without it there is no hub")
    load: Annotated[tuple[Load, ...], AsTuple] = Field(default=(), description="an array of tables [[load]]")
    integrator: Integrator = Field(default=Integrator(), description="a table")
    output: Output = Field(default=Output(), description="a table")
    probe: Annotated[tuple[Probe, ...], AsTuple] = Field(default=(), description="an array of tables [[probe]]")
    verification: Verification | None = Field(default=None, description="a table: results that are known")

    def __init__(self, **values: Any):
        try:
            super().__init__(**values)
        except ValidationError as error:
            raise input_error(error, values, type(self)) from None

    @property
    def directory(self) -> Path:
        """Folder of the FOLD file, whose path is absolute; the current folder without one."""
        return Path(self.pattern.file).parent if self.pattern.kind == "fold" else Path.cwd()

    @property
    def turns(self) -> bool:
        """Whether a hub or an initial spin lets expect that everything turns: spin is recorded."""
        return self.hub is not None or any(load.kind == "initial_spin" for load in self.load)

    def to_toml(self) -> str:
        """The scene as a TOML file; reading it gives an equal scene. The path of a FOLD file is absolute."""
        return tomli_w.dumps(self.model_dump(exclude_none=True))

    @model_validator(mode="after")
    def _complete(self):
        if not re.fullmatch(r"\w[\w +.-]{0,99}", self.name):
            raise fault("name", show(self.name), type(self).model_fields["name"].description)
        self._refuse_repeated_names()
        self._refuse_endless_runs()
        probes = tuple(
            probe if probe.name else probe.model_copy(update={"name": _free_name("probe", i, self.probe)})
            for i, probe in enumerate(self.probe)
        )
        object.__setattr__(self, "probe", probes)
        if self.contact is not None and self.contact.friction > 0.0 and self.analysis.kind != "dynamic":
            wants = '0 where analysis.kind is not "dynamic": friction belongs to motion in time'
            raise fault("contact.friction", self.contact.friction, wants)
        for key in ("driver", "load"):
            completed = tuple(self._with_profile(f"{key}.{i}", item) for i, item in enumerate(getattr(self, key)))
            object.__setattr__(self, key, completed)
        if self.hub is not None and self.hub.mount == "driven":
            object.__setattr__(self, "hub", self._with_profile("hub", self.hub))
        if self.contact is not None and self.contact.thickness is None:
            contact = self.contact.model_copy(update={"thickness": self.material.thickness})
            object.__setattr__(self, "contact", contact)
        elif self.contact is None and "contact_pressure" in self.output.fields:
            raise fault("output.fields", '"contact_pressure" without contact', "a [contact] table, or other fields")
        return self

    def _refuse_endless_runs(self) -> None:
        if self.analysis.kind != "dynamic":
            return
        duration, fps, step = self.analysis.duration, self.output.fps, self.integrator.step
        if fps != "steps" and duration * fps > MOST_FRAMES:
            got = f"{fps:g} beside a duration of {duration:g} s, {duration * fps:.3g} frames"
            raise fault("output.fps", got, f"at most {MOST_FRAMES} frames")
        if step != "auto" and duration / step > MOST_STEPS:
            got = f"{step:g} beside a duration of {duration:g} s, {duration / step:.3g} steps"
            raise fault("integrator.step", got, f"at most {MOST_STEPS} steps")

    def _refuse_repeated_names(self) -> None:
        # supports and drivers share the columns of reactions.csv
        owners: dict[str, str] = {}
        if self.hub is not None and self.hub.mount != "free":
            owners["hub"] = "the hub"
        movers = [(f"{key}.{i}", item) for key in ("support", "driver") for i, item in enumerate(getattr(self, key))]
        for place, item in movers:
            if item.name is not None and item.name in owners:
                wants = f"a name that no other support or driver has ({owners[item.name]} has it)"
                raise fault(f"{place}.name", repr(item.name), wants)
            owners[item.name] = place
        names = [probe.name for probe in self.probe]
        for i, name in enumerate(names):
            if name is not None and name in names[:i]:
                wants = f"a name that no other probe has (probe.{names.index(name)} has it)"
                raise fault(f"probe.{i}.name", repr(name), wants)

    def _with_profile(self, place: str, item: Any) -> Any:
        if "profile" not in type(item).model_fields:
            if self.analysis.kind != "dynamic":
                raise fault(
                    f"{place}.kind",
                    f'"{item.kind}"',
                    'an initial velocity or spin only where analysis.kind is "dynamic"',
                )
            return item
        profile: Profile = item.profile or self._default_profile(item)
        try:
            profile = profile.completed(self.analysis.end)
        except PydanticCustomError as error:
            raise fault(f"{place}.profile.{error.context['key']}", *_got_wants(error)) from None
        initial = profile.factor()(0.0)
        if isinstance(item, Driver | Hub) and initial != 0.0:
            raise fault(
                f"{place}.profile",
                f"factor {initial:g} at time 0",
                "factor 0 at time 0: drivers leave the initial state",
            )
        return item.model_copy(update={"profile": profile})

    def _default_profile(self, item: Any) -> Profile:
        if self.analysis.kind != "dynamic":
            return Profile(kind="linear")
        return Profile(kind="smooth") if isinstance(item, Driver | Hub) else Profile(kind="constant")


def _got_wants(error: PydanticCustomError) -> tuple[str, str]:
    return error.context["got"], error.context["wants"]


def _free_name(stem: str, number: int, items: tuple) -> str:
    taken = {item.name for item in items}
    while f"{stem}{number}" in taken:
        number += 1
    return f"{stem}{number}"
