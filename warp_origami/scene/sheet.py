"""What the sheet is: its pattern and its material."""

import math
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from warp_origami.model.fold import read_fold
from warp_origami.model.generators.annulus import default_segments
from warp_origami.model.generators.disc import SEGMENTS_PER_RING
from warp_origami.model.generators.leaf_in import default_corner, default_inset
from warp_origami.model.ring_mesh import GRADINGS

from .base import AsTuple, Count, NotNegative, Number, Positive, Table, Vector2, fault

REFINE_WANTS = "an integer >= 1: every triangle is split into refine^2 elements"
UNFOLDED_WANTS = '"flat" or { stretch = [a, b] }'
INITIAL_WANTS = '"flat", "stowed" or { stretch = [a, b] } (unless given: stowed where there is such a state)'


class Stretch(Table):
    """The flat sheet scaled in its plane."""

    stretch: Annotated[tuple[Positive, Positive], AsTuple] = Field(description="two factors > 0, along x and y")


GridLines = Annotated[tuple[Count, ...], AsTuple]
Initial = Literal["flat", "stowed"] | Stretch
MOST = 200
"""Strips, columns and cells of one pattern: beyond, its elements are counted in hundred thousands."""

Several = Annotated[Count, Field(le=MOST)]
Opening = Annotated[NotNegative, Field(le=math.pi)]
Grading = Annotated[Positive, Field(ge=GRADINGS[0], le=GRADINGS[1])]


class PatternTable(Table):
    """A pattern of some kind; the fields but `kind` and `initial` are the parameters of its generator."""

    def parameters(self) -> dict[str, Any]:
        """Arguments for the generator of this kind of pattern."""
        return {name: getattr(self, name) for name in type(self).model_fields if name not in ("kind", "initial")}


def _complete_initial(table: "Sheet | Miura") -> None:
    """The initial state of a pattern that is stowed by its `opening`: stowed where it has one."""
    if table.initial is None:
        object.__setattr__(table, "initial", "flat" if table.opening is None else "stowed")
    if table.initial == "stowed" and table.opening is None:
        raise fault("initial", '"stowed"', '"flat" or { stretch = [a, b] }, or an opening that says how it is stowed')


class LeafIn(PatternTable):
    """The leaf-in square: nested squares, diagonals and medians."""

    kind: Literal["leaf_in"] = Field(description='"leaf_in"')
    side: Positive = Field(default=0.6, description="a number > 0: side of the square, m")
    inset: NotNegative | None = Field(
        default=None,
        description="a number >= 0, m: how far ring middles but the last lie inside their squares "
        "(unless given: a twentieth of the narrowest ring)",
    )
    corner_distance: Positive | None = Field(
        default=None,
        description="a number > 0, m: distance of the stowed corners from the axis "
        "(unless given: 0.52 side; of other rings the first of some at which nothing crosses)",
    )
    rings: Annotated[Count, Field(ge=2, le=13)] = Field(default=3, description="an integer from 2 to 13: rings")
    widths: Annotated[tuple[Positive, ...], AsTuple] | None = Field(
        default=None,
        description="a list of numbers > 0: widths of the rings from the centre over each other (unless given: equal)",
    )
    refine: Count = Field(default=1, description=REFINE_WANTS)
    initial: Initial = Field(default="stowed", description=INITIAL_WANTS)

    @model_validator(mode="after")
    def _complete(self):
        if self.widths is not None and len(self.widths) != self.rings:
            raise fault("widths", f"{len(self.widths)} numbers", f"{self.rings}, one for each of the rings")
        if self.inset is None:
            object.__setattr__(self, "inset", default_inset(self.rings, self.widths) * self.side)
        if self.corner_distance is None:
            corner = default_corner(self.rings, self.widths, self.inset / self.side)
            object.__setattr__(self, "corner_distance", corner * self.side)
        return self


class Sheet(PatternTable):
    """A rectangle of nx by ny cells of two triangles each, plain or folded like a fan."""

    kind: Literal["sheet"] = Field(description='"sheet"')
    width: Positive = Field(default=1.0, description="a number > 0: extent along x, m")
    height: Positive = Field(default=1.0, description="a number > 0: extent along y, m")
    nx: Count = Field(default=1, description="an integer >= 1: cells along x")
    ny: Count = Field(default=1, description="an integer >= 1: cells along y")
    origin: Vector2 = Field(default=(0.0, 0.0), description="[x, y], m: the corner with the least x and y")
    diagonal: Literal["right", "alternate"] = Field(default="right", description='"right" or "alternate"')
    creases_x: GridLines = Field(default=(), description="a list of grid lines x = i width / nx, 0 < i < nx")
    creases_y: GridLines = Field(default=(), description="a list of grid lines y = j height / ny, 0 < j < ny")
    opening: Annotated[Positive, Field(le=math.pi)] | None = Field(
        default=None, description="a number > 0 and <= pi, rad: angle between neighbouring panels when stowed"
    )
    refine: Count = Field(default=1, description=REFINE_WANTS)
    initial: Initial | None = Field(default=None, description=INITIAL_WANTS)

    @model_validator(mode="after")
    def _complete(self):
        _complete_initial(self)
        return self


class Miura(PatternTable):
    """A Miura sheet: parallelograms between straight creases along x and zigzags along y."""

    kind: Literal["miura"] = Field(description='"miura"')
    nx: Count = Field(description="an integer >= 1: parallelograms along x")
    ny: Count = Field(description="an integer >= 1: parallelograms along y")
    a: Positive = Field(description="a number > 0: side of a parallelogram along x, m")
    b: Positive = Field(description="a number > 0: side of the zigzags, m")
    sector_angle: Annotated[Positive, Field(lt=0.5 * math.pi)] = Field(
        description="a number > 0 and < pi/2: acute angle of the parallelograms, rad"
    )
    opening: Opening | None = Field(
        default=None, description="a number from 0 to pi, rad: angle between panels at a zigzag when stowed"
    )
    refine: Count = Field(default=1, description=REFINE_WANTS)
    initial: Initial | None = Field(default=None, description=INITIAL_WANTS)

    @model_validator(mode="after")
    def _complete(self):
        _complete_initial(self)
        return self


class CrossFold(PatternTable):
    """A square sail of four petals folded into strips: stowed, a cross of four arms around a hub."""

    kind: Literal["cross_fold"] = Field(description='"cross_fold"')
    side: Positive = Field(default=14.0, description="a number > 0: side of the square, m")
    hub: NotNegative = Field(default=1.2, description="a number >= 0 and < side: side of the opening for the hub, m")
    strips: Annotated[Count, Field(ge=2, le=MOST)] = Field(
        default=10, description=f"an integer from 2 to {MOST}: strips of each petal"
    )
    opening: Annotated[NotNegative, Field(le=0.5 * math.pi)] = Field(
        default=0.1, description="a number from 0 to pi/2, rad: angle between neighbouring strips when stowed"
    )
    columns: Several | None = Field(
        default=None,
        description=f"an integer from 1 to {MOST}: element sides along half a side (unless given: as long as strips)",
    )
    slits: Annotated[NotNegative, Field(lt=1.0)] = Field(
        default=0.0, description="a number >= 0 and < 1: share of the diagonals that is open, between bridges"
    )
    refine: Count = Field(default=1, description=REFINE_WANTS)
    initial: Initial = Field(default="stowed", description=INITIAL_WANTS)

    @model_validator(mode="after")
    def _complete(self):
        if not self.hub < self.side:
            raise fault("hub", self.hub, f"less than side, which is {self.side} (m)")
        return self


class LeafOut(PatternTable):
    """The leaf-out square: four leaves whose veins lead outwards from the diagonals."""

    kind: Literal["leaf_out"] = Field(description='"leaf_out"')
    side: Positive = Field(default=0.6, description="a number > 0: side of the square, m")
    strips: Several = Field(default=3, description=f"an integer from 1 to {MOST}: strips of each half of a side")
    opening: Opening = Field(
        default=0.2, description="a number from 0 to pi, rad: angle between neighbouring strips when stowed"
    )
    columns: Several = Field(default=1, description=f"an integer from 1 to {MOST}: elements along the longest vein")
    refine: Count = Field(default=1, description=REFINE_WANTS)
    initial: Initial = Field(default="stowed", description=INITIAL_WANTS)


class ZFold(PatternTable):
    """A rectangle folded like an accordion."""

    kind: Literal["z_fold"] = Field(description='"z_fold"')
    length: Positive = Field(default=1.0, description="a number > 0: extent along x, across the fold lines, m")
    width: Positive = Field(default=0.2, description="a number > 0: extent along y, along the fold lines, m")
    strips: Annotated[Count, Field(ge=2, le=MOST)] = Field(
        default=8, description=f"an integer from 2 to {MOST}: strips of equal width"
    )
    columns: Several | None = Field(
        default=None,
        description=f"an integer from 1 to {MOST}: elements along a fold line (unless given: strips are as wide)",
    )
    opening: Opening = Field(
        default=0.1, description="a number from 0 to pi, rad: angle between neighbouring strips when stowed"
    )
    refine: Count = Field(default=1, description=REFINE_WANTS)
    initial: Initial = Field(default="stowed", description=INITIAL_WANTS)


class SquareTwist(PatternTable):
    """Squares that turn while the pleats between them close."""

    kind: Literal["square_twist"] = Field(description='"square_twist"')
    nx: Several = Field(default=1, description=f"an integer from 1 to {MOST}: twists along x")
    ny: Several = Field(default=1, description=f"an integer from 1 to {MOST}: twists along y")
    cell: Positive = Field(default=0.3, description="a number > 0: side of the cell of a twist, m")
    twist: Positive = Field(default=0.1, description="a number > 0: side of the squares that turn, m")
    angle: Annotated[Positive, Field(lt=0.5 * math.pi)] = Field(
        default=0.25 * math.pi, description="a number > 0 and < pi/2: angle between the squares and their pleats, rad"
    )
    assignment: Literal["rigid", "classic"] = Field(
        default="rigid", description='"rigid" (sides of the squares M M V V) or "classic" (M M M M)'
    )
    opening: Opening | None = Field(
        default=None,
        description="a number from 0 to pi, rad: angle between faces at the most closed creases when stowed "
        '(unless given: "rigid" 0.3; "classic" 0, nothing else)',
    )
    refine: Count = Field(default=1, description=REFINE_WANTS)
    initial: Initial = Field(default="stowed", description=INITIAL_WANTS)

    @model_validator(mode="after")
    def _complete(self):
        if self.opening is None:
            object.__setattr__(self, "opening", 0.3 if self.assignment == "rigid" else 0.0)
        if self.assignment == "classic" and self.opening != 0.0:
            raise fault("opening", self.opening, '0 for "classic", which does not fold rigidly')
        return self


class RoundTable(PatternTable):
    """A round sheet in rings of triangles, without creases."""

    rings: Count = Field(description="an integer >= 1: rings of triangles")
    segments: Annotated[Count, Field(ge=3)] | None = Field(
        default=None,
        description="an integer >= 3: edges of the outer rim (unless given: as many as make triangles even)",
    )
    grading: Grading = Field(
        default=1.0,
        description="a number from {:g} to {:g}: width of the outermost ring over that of the innermost".format(
            *GRADINGS
        ),
    )
    centre: Vector2 = Field(default=(0.0, 0.0), description="[x, y], m")
    refine: Count = Field(default=1, description=REFINE_WANTS)
    initial: Literal["flat"] | Stretch = Field(default="flat", description=UNFOLDED_WANTS)


class Disc(RoundTable):
    """A disc, with a vertex at its centre."""

    kind: Literal["disc"] = Field(description='"disc"')
    radius: Positive = Field(description="a number > 0: radius of the rim, m")

    @model_validator(mode="after")
    def _complete(self):
        if self.segments is None:
            object.__setattr__(self, "segments", SEGMENTS_PER_RING * self.rings)
        return self


class Annulus(RoundTable):
    """A disc with a round hole."""

    kind: Literal["annulus"] = Field(description='"annulus"')
    inner_radius: Positive = Field(description="a number > 0 and below outer_radius: radius of the inner rim, m")
    outer_radius: Positive = Field(description="a number > 0: radius of the outer rim, m")

    @model_validator(mode="after")
    def _complete(self):
        if not self.inner_radius < self.outer_radius:
            raise fault("inner_radius", self.inner_radius, f"less than outer_radius, which is {self.outer_radius} (m)")
        if self.segments is None:
            segments = default_segments(self.inner_radius, self.outer_radius, self.rings)
            object.__setattr__(self, "segments", segments)
        return self


class Fold(PatternTable):
    """A crease pattern in a FOLD file."""

    kind: Literal["fold"] = Field(description='"fold"')
    file: str = Field(min_length=1, description="path of a FOLD file, relative to the folder of the scene file")
    refine: Count = Field(default=1, description=REFINE_WANTS)
    initial: Initial | None = Field(default=None, description=INITIAL_WANTS)

    @model_validator(mode="after")
    def _complete(self):
        path = Path(self.file).absolute()
        try:
            there = path.is_file()  # neither a pipe nor a device
        except (OSError, ValueError):  # a name that no file can have
            there = False
        if not there:
            name = repr(str(path))
            shown = name if len(name) <= 300 else f"{name[:100]}...{name[-100:]}"
            raise fault("file", f"{shown}, where no file is", "path of a readable FOLD file")
        object.__setattr__(self, "file", str(path))
        if self.initial is None:
            object.__setattr__(self, "initial", "flat" if read_fold(path).stowed is None else "stowed")
        return self


Pattern = Annotated[
    LeafIn | LeafOut | Sheet | Miura | ZFold | CrossFold | SquareTwist | Disc | Annulus | Fold,
    Field(discriminator="kind"),
]


class Material(Table):
    """Linear elastic or wrinkling (stiffness reduction) membrane, with Rayleigh damping."""

    density: Positive = Field(description="a number > 0: density, kg/m^3")
    youngs_modulus: Annotated[Positive, Field(le=1e15)] = Field(
        description="a number > 0 and <= 1e15: Young's modulus, Pa"
    )
    poisson_ratio: Annotated[Number, Field(gt=-1.0, lt=0.5)] = Field(description="a number between -1 and 0.5")
    thickness: Positive = Field(description="a number > 0: thickness, m")
    model: Literal["srm", "linear"] = Field(default="srm", description='"srm" (wrinkling) or "linear"')
    s1: Annotated[Positive, Field(le=1.0)] = Field(
        default=1e-4, description="a number > 0 and <= 1: residual stiffness of wrinkled material over the full one"
    )
    s2: Annotated[Positive, Field(le=1.0)] = Field(
        default=1e-4, description="a number > 0 and <= 1: residual stiffness of slack material over the full one"
    )
    mass_damping: NotNegative = Field(default=0.0, description="a number >= 0: alpha of Rayleigh damping, 1/s")
    stiffness_damping: NotNegative = Field(default=0.0, description="a number >= 0: beta of Rayleigh damping, s")
