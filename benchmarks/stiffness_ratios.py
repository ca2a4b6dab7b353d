"""How far static and modal results depend on the stiffness ratios s1 (wrinkled) and s2 (slack).

    python benchmarks/stiffness_ratios.py

Runs every case over s1 = s2 = 1e-2 ... 1e-6, and with one of them kept at 1e-6, on one mesh each, so that what differs
is due to the ratios alone. Prints a table and writes results/stiffness_ratios.csv and .png. docs/stiffness_ratios.md
says what the cases are and what follows.
"""

import csv
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import warp as wp

import warp_origami as wo
from warp_origami.errors import NumericalFailure

SMALLEST = 1e-6
RATIOS = (1e-2, 1e-3, 1e-4, 1e-5, SMALLEST)
RESULTS = Path(__file__).parent / "results"
MODULUS, THICKNESS, SIDE = 2.5e9, 5e-4, 0.6
POLYIMIDE = {"density": 1420.0, "youngs_modulus": MODULUS, "poisson_ratio": 0.34, "thickness": THICKNESS}


@dataclass(frozen=True)
class Case:
    """A scene, and the numbers read off its result.

    Attributes:
        tables: fields of the scene but name and stiffness ratios.
        read: names and values of what is compared.
        material: changes to polyimide.
    """

    name: str
    tables: dict
    read: Callable[[wo.Run], dict[str, float]]
    material: dict


def main() -> None:
    """Runs all cases over all ratios."""
    wp.config.quiet = True
    pairs = [(s, s) for s in RATIOS] + [(s, SMALLEST) for s in RATIOS[:-1]] + [(SMALLEST, s) for s in RATIOS[:-1]]
    table: dict[tuple[str, str], dict[tuple[float, float], float]] = {}
    for case in cases():
        for pair in pairs:
            try:
                result = case.read(run(case, *pair))
            except NumericalFailure as failure:
                print(f"{case.name}, s1 = {pair[0]:g}, s2 = {pair[1]:g}: {failure}", flush=True)
                continue
            for quantity, value in result.items():
                table.setdefault((case.name, quantity), {})[pair] = value
        show(case.name, table, pairs)
    write(table, pairs)
    draw(table)


def run(case: Case, s1: float, s2: float) -> wo.Run:
    """The case at these ratios."""
    material = POLYIMIDE | case.material | {"s1": s1, "s2": s2}
    return wo.simulate(wo.Scene(name="ratios", material=material, output={"fields": []}, **case.tables), device="cpu")


def cases() -> list[Case]:
    """Static cases, then modal ones."""
    return [taut_deflection(), pillow(), annulus(), bent_rectangle(), *modal_cases()]


def taut_deflection() -> Case:
    """A drum under a light pressure."""
    tables = {
        "analysis": {"kind": "static", "load_steps": 1},
        "pattern": square(8) | {"initial": {"stretch": [1.000264, 1.000264]}},
        "support": [{"at": {"boundary": True}}],
        "load": [{"kind": "pressure", "value": 10.0}],
        "probe": [{"name": "centre", "at": [SIDE / 2, SIDE / 2]}],
    }
    return Case("taut drum", tables, lambda r: {"deflection": r.probes["centre"][-1, 2]}, {})


def pillow() -> Case:
    """Two discs seamed and inflated, p a / (E h) = 8.5e-3."""
    tables = {
        "analysis": {"kind": "static", "load_steps": 1},
        "pattern": {"kind": "disc", "radius": 0.6, "rings": 6, "segments": 48},
        "support": [
            {"at": {"boundary": True}, "fix": "z"},
            {"at": {"near": [0.0, 0.0]}, "fix": "xy"},
            {"at": {"near": [0.6, 0.0]}, "fix": "y"},
        ],
        "load": [{"kind": "pressure", "value": 5e3}],
        "probe": [{"name": "pole", "at": [0.0, 0.0]}, {"name": "rim", "at": [0.6, 0.0]}],
    }
    material = {"youngs_modulus": 588e6, "poisson_ratio": 0.4, "thickness": 6e-4}
    return Case(
        "pillow", tables, lambda r: {"height": r.probes["pole"][-1, 2], "radius": r.probes["rim"][-1, 0]}, material
    )


def annulus() -> Case:
    """A prestressed annulus twisted by its hub until it is wrinkled to 1.5 times the hub's radius."""
    prestress = 1e-4
    stretch = float(np.sqrt(1.0 + 2.0 * prestress * 0.7))
    turn = {"axis": [0.0, 0.0, 1.0], "angle": 4.24936 * prestress}
    tables = {
        "analysis": {"kind": "static", "load_steps": 1},
        "pattern": {
            "kind": "annulus",
            "inner_radius": 0.2,
            "outer_radius": 0.5,
            "rings": 8,
            "segments": 64,
            "initial": {"stretch": [stretch, stretch]},
        },
        "support": [{"name": "rim", "at": {"circle": [0.0, 0.0, 0.5]}}],
        "driver": [{"name": "hub", "at": {"circle": [0.0, 0.0, 0.2]}, "rotate": turn}],
    }
    first = 2.0 * np.pi * THICKNESS * 0.2**2 * prestress * MODULUS
    return Case(
        "twisted annulus", tables, lambda r: {"torque": r.reactions["hub"][-1, 5] / first}, {"poisson_ratio": 0.3}
    )


def bent_rectangle() -> Case:
    """A stretched rectangle bent in its plane until half of it is wrinkled: k' = 4, P / (E t H) = 1e-5."""
    height, length, k = 0.2, 0.4, 4.0
    force = 1e-5 * MODULUS * THICKNESS * height
    curvature, neutral = 2.0 * k * 1e-5 / height, height * (1.0 - k**-0.5)
    turn = {"axis": [0.0, 0.0, -1.0], "centre": [length, neutral, 0.0], "angle": length * curvature}
    tables = {
        "analysis": {"kind": "static", "load_steps": 1},
        "pattern": {"kind": "sheet", "width": length, "height": height, "nx": 16, "ny": 8, "diagonal": "alternate"},
        "support": [
            {"at": {"all": True}, "fix": "z"},
            {"at": {"box": [[0.0, 0.0], [0.0, height]]}, "fix": "x"},
            {"at": {"near": [0.0, height]}, "fix": "y"},
        ],
        "driver": [{"name": "end", "at": {"box": [[length, 0.0], [length, height]]}, "axes": "x", "rotate": turn}],
    }

    def read(result: wo.Run) -> dict[str, float]:
        reaction = result.reactions["end"][-1]
        return {"moment": 2.0 * abs(reaction[5] + 0.5 * height * reaction[0]) / (force * height)}

    return Case("bent rectangle", tables, read, {})


def modal_cases() -> list[Case]:
    """Squares of 0.6 m: taut, pulled along x, uniformly wrinkled, sheared."""
    clamp, pull = box([0.0, 0.0], [0.0, SIDE]), box([SIDE, 0.0], [SIDE, SIDE])
    bottom, top = box([0.0, 0.0], [SIDE, 0.0]), box([0.0, SIDE], [SIDE, SIDE])
    rim = {"support": [{"at": {"boundary": True}}]}
    towed = {"support": [{"at": clamp}], "driver": [{"at": pull, "translate": [1e-3 * SIDE, 0.0, 0.0]}]}
    sheared = {"support": [{"at": bottom}], "driver": [{"at": top, "translate": [1e-3 * SIDE, 0.0, 0.0]}]}
    taut, wrinkled = {"stretch": [1.000264, 1.000264]}, {"stretch": [1.001, 0.999]}
    settings = [
        ("taut drum, modes", square(8) | {"initial": taut}, rim),
        ("pulled sheet, modes", square(8), towed),
        ("wrinkled drum, modes", square(8) | {"initial": wrinkled}, rim),
        ("wrinkled drum, fine, modes", square(16) | {"initial": wrinkled}, rim),
        ("sheared sheet, modes", square(8) | {"initial": taut}, sheared),
    ]
    analysis = {"kind": "modal", "count": 12, "load_steps": 1}
    return [
        Case(name, {"analysis": analysis, "pattern": pattern} | held, modes, {}) for name, pattern, held in settings
    ]


def modes(result: wo.Run) -> dict[str, float]:
    """Hz."""
    found = result.summary["frequencies"]
    return {"f1": found[0], "f4": found[3], "f12": found[11]}


def square(cells: int) -> dict:
    """A square sheet."""
    return {"kind": "sheet", "width": SIDE, "height": SIDE, "nx": cells, "ny": cells}


def box(low: list[float], high: list[float]) -> dict:
    """A selector."""
    return {"box": [low, high]}


def show(name: str, table: dict, pairs: list) -> None:
    """Prints what was found of one case: the values, and how far they are from those at the smallest ratios."""
    for (case, quantity), values in table.items():
        if case != name:
            continue
        print(f"\n{case}: {quantity} = {values[SMALLEST, SMALLEST]:.6g} at s1 = s2 = {SMALLEST:g}")
        for pair in pairs:
            if pair in values:
                print(f"  s1 {pair[0]:.0e}  s2 {pair[1]:.0e}  {values[pair]:12.6g}  {change(values, pair):+.2e}")
    print(end="", flush=True)


def change(values: dict[tuple[float, float], float], pair: tuple[float, float]) -> float:
    """Relative to the value at the smallest ratios."""
    return values[pair] / values[SMALLEST, SMALLEST] - 1.0


def write(table: dict, pairs: list) -> None:
    """results/stiffness_ratios.csv."""
    RESULTS.mkdir(exist_ok=True)
    with open(RESULTS / "stiffness_ratios.csv", "w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["case", "quantity", "s1", "s2", "value", "relative_change"])
        for (case, quantity), values in table.items():
            for pair in pairs:
                if pair in values:
                    rows.writerow(
                        [
                            case,
                            quantity,
                            *map("{:g}".format, pair),
                            f"{values[pair]:.9g}",
                            f"{change(values, pair):.3e}",
                        ]
                    )


def draw(table: dict) -> None:
    """results/stiffness_ratios.png: relative changes over s1 = s2, of cases that change at all."""
    figure, axes = plt.subplots(1, 2, figsize=(11, 4.5), sharey=True)
    colours: dict[str, str] = {}
    for (case, quantity), values in table.items():
        pairs = [(s, s) for s in RATIOS[:-1] if (s, s) in values]
        changes = [abs(change(values, pair)) for pair in pairs]
        if max(changes) < 1e-12 or quantity == "f4":
            continue
        modal = case.endswith(", modes")
        colour = colours.setdefault(case, f"C{len(colours)}")
        style = "s--" if quantity in ("f12", "radius") else "o-"
        label = f"{case.removesuffix(', modes')}: {quantity}"
        axes[int(modal)].loglog([s for s, _ in pairs], changes, style, color=colour, label=label, markersize=4)
    axes[0].set(title="statics", xlabel="s1 = s2", ylabel=f"relative change against s1 = s2 = {SMALLEST:g}")
    axes[1].set(title="frequencies (above 1: unstable)", xlabel="s1 = s2")
    axes[0].set_ylim(1e-7, 1e3)  # room for the legends
    for axis in axes:
        axis.grid(True, alpha=0.3)
        axis.legend(fontsize=8, loc="upper left", ncols=2)
    figure.tight_layout()
    figure.savefig(RESULTS / "stiffness_ratios.png", dpi=110)


if __name__ == "__main__":
    main()
