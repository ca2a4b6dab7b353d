"""Crumpling: a folded sheet whose vertices start with random velocities, many seeds.

    python benchmarks/crumpling.py [--seeds 50] [--speed 0.7] [--scene hard/crumpling] [--out FILE]

A run is as it should be when it ends with status `done`, no accepted step crosses (oracle on a finer sub-mesh), all
numbers are finite, less than 0.5 % of energy is created, and layers did touch. Writes results/crumpling.csv, a row as
soon as a run has ended; seeds that are there already are not repeated.
"""

import argparse
from pathlib import Path

from watched_runs import RESULTS, fill_table, row, watch, with_random_velocities

from warp_origami.scene import load_scene

LARGEST_GAIN = 5e-3


def faults(found: dict) -> list[str]:
    """What is wrong with a run."""
    wrong = [] if found["status"] == "done" else [found["status"]]
    wrong += ["passes through itself"] if int(found["crossings"]) or int(found["passages"]) else []
    wrong += [] if str(found["finite"]) == "True" else ["not finite"]
    wrong += ["creates energy"] if not float(found["energy_gain"]) < LARGEST_GAIN else []
    touched = any(int(found[column]) for column in ("contacts_sts", "contacts_nts", "contacts_edge"))
    return wrong + ([] if touched else ["no contact"])


def main() -> None:
    """Runs what is not in the table yet, and counts the runs that are as they should be."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=50)
    parser.add_argument("--speed", type=float, default=0.7, help="standard deviation of each component, m/s")
    parser.add_argument("--scene", default="hard/crumpling")
    parser.add_argument("--out", type=Path, default=RESULTS / "crumpling.csv")
    options = parser.parse_args()
    base = load_scene(options.scene)

    def run(label: dict) -> dict:
        scene = with_random_velocities(base, options.speed, label["seed"])
        return row(label, scene, *watch(scene))

    labels = [
        {"scene": options.scene, "contact": base.contact.method, "seed": seed} for seed in range(1, options.seeds + 1)
    ]
    good = 0
    for found in fill_table(options.out, labels, run):
        wrong = faults(found)
        good += not wrong
        print(
            f"seed {found['seed']}: {', '.join(wrong) or 'good'}; {found['steps']} steps, depth "
            f"{found['depth_over_thickness']} of the thickness, gain {found['energy_gain']}, {found['seconds']} s",
            flush=True,
        )
    print(f"{good} of {len(labels)} runs are as they should be")


if __name__ == "__main__":
    main()
