"""Scenes that are hard for contact, every accepted step held against an independent oracle.

    python benchmarks/no_crossing.py [SCENE ...] [--seeds 10] [--speed 0.05] [--without-contact] [--out FILE]

Without scenes: leaf_in and all of scenes/hard. Seed 0 is the scene as it is; the others add random velocities of
`--speed` to every vertex. Writes results/no_crossing.csv, a row as soon as a run has ended; runs that are there already
are not repeated, so that the table can be stopped and resumed (delete it to begin anew).
"""

import argparse
from pathlib import Path

from warp_origami.scenes import bundled_scenes
from watched_runs import RESULTS, fill_table, row, watch, with_random_velocities, without_contact

from warp_origami.scene import load_scene

FOLDER = "hard/"


def main() -> None:
    """Runs what is not in the table yet and prints the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", nargs="*", help="names or paths of scenes")
    parser.add_argument("--seeds", type=int, default=0, help="how many runs with random velocities")
    parser.add_argument("--speed", type=float, default=0.05, help="standard deviation of each component, m/s")
    parser.add_argument("--without-contact", action="store_true", help="show that the scenes cross without contact")
    parser.add_argument("--until", type=float, help="s, end earlier")
    parser.add_argument("--set", action="append", default=[], help="changes of the scenes, key.path=value")
    parser.add_argument("--out", type=Path, default=RESULTS / "no_crossing.csv")
    options = parser.parse_args()
    names = options.scenes or ["leaf_in", *(name for name in bundled_scenes() if name.startswith(FOLDER))]
    names = [FOLDER + name if FOLDER + name in bundled_scenes() else name for name in names]

    def run(label: dict) -> dict:
        scene = load_scene(label["scene"], options.set)
        scene = without_contact(scene) if options.without_contact else scene
        if label["seed"]:
            scene = with_random_velocities(scene, options.speed, label["seed"])
        return row(label, scene, *watch(scene, options.until))

    labels = []
    for name in names:
        contact = "none" if options.without_contact else load_scene(name, options.set).contact.method
        labels += [{"scene": name, "contact": contact, "seed": seed} for seed in range(options.seeds + 1)]
    crossed = 0
    for found in fill_table(options.out, labels, run):
        print("  ".join(f"{key} {value}" for key, value in found.items()), flush=True)
        crossed += int(found["crossings"]) > 0 or int(found["passages"]) > 0
    print(f"{crossed} of {len(labels)} runs pass through themselves")


if __name__ == "__main__":
    main()
