"""What the search for contact costs from 48 to 50 000 elements, and how often it is made.

    python benchmarks/broadphase.py [--until 0.7]

stack    A strip of 1 m folded three times into a zigzag of four panels that lie on each other. Panels are m elements
         wide; the opening is 0.5 / m, so that neighbouring panels are 0.25 elements apart on average, and the thickness
         is 0.02 elements: refined, the stack looks the same from each of its elements, and every element has as many
         pairs. Elements are not divided: all that grows is their number.
divided  The same with the sub-triangles that contact takes by itself: 16 of each element at 48, 1 beyond 5000.
film     The same with a thickness of 0.5 mm whatever the mesh: the radius of the search (margin: four times the
         thickness) grows over the elements, and so do the pairs of each element.
graded   Two sheets above each other whose elements grow by a factor of 1000 from the middle to the rim; search alone.

Then the scene leaf_in runs until `--until` and the searches are counted beside the evaluations of contact.

Writes results/broadphase.csv and .png, broadphase_run.csv. Times are CPU seconds of one thread, medians; every size is
measured in its own process. Exponents are slopes of log(seconds) over log(elements) by least squares.
"""

import argparse
import csv
import json
import resource
import subprocess
import sys
import time
from collections import Counter
from itertools import cycle
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import warp as wp
from warp_origami.kernels.precision import vec3

import warp_origami
from warp_origami.model.connectivity import list_edges
from warp_origami.model.coordinates import affine_coordinates, number_coordinates
from warp_origami.model.generators.sheet import sheet
from warp_origami.model.mesh import assemble_mesh
from warp_origami.model.submesh import build_submesh
from warp_origami.scene.settings import Contact as Settings
from warp_origami.terms.contact import Contact, box_pairs
from warp_origami.terms.contact.edge_search import EdgeSearch
from warp_origami.terms.contact.features import submesh_features
from warp_origami.terms.contact.near_features import FeatureSearch
from warp_origami.terms.contact.points import build_points
from warp_origami.terms.contact.search import Search
from warp_origami.terms.contact.surfaces import SurfaceContact

RESULTS = Path(__file__).parent / "results"
SIZES = {
    "stack": (2, 4, 8, 16, 32, 64),
    "divided": (2, 4, 8, 16, 32, 64),
    "film": (8, 16, 32, 64),
    "graded": (6, 12, 24, 48, 100),
}
FILM = 5e-4
REPEATS = 5
FIXED_COST = 700
"""Elements below which what does not depend on their number makes up much of the time."""
PHASES = {
    "grid": ("build_grid",),
    "count": ("count_overlaps",),
    "fill": ("fill_overlaps",),
    "exact": ("find_candidates", "find_part_pairs", "find_vertices_near_triangles", "find_edges_near_edges"),
}
SEARCHES = ("point_search", "edge_search", "feature_search")


class Clock:
    """CPU seconds spent in the phases of a search, by the name of what is called."""

    def __init__(self) -> None:
        self.seconds = Counter()
        wp.launch = self._timed(wp.launch, lambda arguments: arguments[0].key)
        box_pairs.build_grid = self._timed(box_pairs.build_grid, lambda _arguments: "build_grid")

    def _timed(self, call, name):
        def timed(*arguments, **options):
            start = time.process_time()
            result = call(*arguments, **options)
            self.seconds[name(arguments)] += time.process_time() - start
            return result

        return timed

    def median(self, call) -> tuple[float, dict[str, float], object]:
        """Median seconds of a call, those of its phases, and its result; the first of the calls does not count."""
        result = call()
        totals, phases = [], []
        for _ in range(REPEATS):
            self.seconds.clear()
            start = time.process_time()
            call()
            totals.append(time.process_time() - start)
            phases.append({name: sum(self.seconds[key] for key in keys) for name, keys in PHASES.items()})
        return float(np.median(totals)), {name: float(np.median([p[name] for p in phases])) for name in PHASES}, result


def memory() -> float:
    """Memory of this process now, MB."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize() / 1e6


def stack(m: int, thickness: float | None):
    """Mesh, coordinates, settings of contact and state of the stack; thickness None: 0.02 elements."""
    cells, width = 3 * m // 2, 0.25 / m
    pattern = sheet(1.0, cells * width, 4 * m, cells, creases_x=(m, 2 * m, 3 * m), opening=0.5 / m)
    coordinates = number_coordinates(pattern.mesh)
    q = affine_coordinates(pattern.mesh, coordinates, pattern.stowed)
    return pattern.mesh, coordinates, Settings(thickness=thickness or 0.02 * width), q


def measure_stack(m: int, thickness: float | None, divisions: int | None) -> dict[str, float]:
    """One size of the stack. Looks into the parts of Contact, which are private."""
    Contact(*stack(2, None))  # kernels are loaded
    mesh, coordinates, settings, q = stack(m, thickness)
    clock, before, start = Clock(), memory(), time.process_time()
    contact = Contact(mesh, coordinates, settings, q, divisions=divisions)
    setup = time.process_time() - start
    row = {"elements": len(mesh.triangles), "setup": setup, "memory_MB": memory() - before}
    row["peak_memory_MB"] = max(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e6 - before, 0.0)
    surfaces, edges, facets = contact._surfaces, contact._edges, contact._terms["facets"]
    radius, features, nodes = surfaces._reach + surfaces._margin, facets._search, facets._x
    if divisions is not None:  # facets have their own
        features = FeatureSearch(submesh_features(mesh, coordinates, contact.submesh), "cpu")
        nodes = surfaces._nodes.array.numpy()
    calls = {
        "point_search": lambda: surfaces._search.within(surfaces._slaves.array, surfaces._nodes.array, radius),
        "edge_search": lambda: edges._search.within(edges._controls.array, edges._reach + edges._margin),
        "feature_search": lambda: features.within(nodes, facets._radius),
    }
    phases, pairs = Counter(), {}
    for name, call in calls.items():
        row[name], parts, result = clock.median(call)
        phases.update(parts)
        pairs[name] = len(result.distances) if name == "feature_search" else len(result.candidates)
    row |= {f"search_{name}": phases[name] for name in PHASES}
    row["search"] = sum(row[name] for name in SEARCHES)
    row |= {f"{name}_pairs": count for name, count in pairs.items()}
    row["narrow_phase"] = clock.median(lambda: surfaces._narrow.launch(0.0))[0]
    states = cycle([q, q + 1e-12])  # the state last evaluated would not be evaluated again
    row["rest_of_evaluation"] = clock.median(lambda: contact.gradient(next(states)))[0] - row["narrow_phase"]
    row["sub_triangles"], row["slave_points"] = len(contact.submesh.triangles), surfaces._points.slave_count
    row["thin_pairs"] = len(surfaces._table.keys)
    return row


def graded_mesh(around: int):
    """Two half discs beside each other whose rings grow in proportion to their radius, 1 mm to 1 m; (mesh, stowed)."""
    rings = int(np.log(1000.0) / np.log1p(np.pi / around))
    radius, angle = np.meshgrid(np.logspace(-3, 0, rings + 1), np.linspace(0.0, np.pi, around + 1), indexing="ij")
    vertices = np.stack([(radius * np.cos(angle)).ravel(), (radius * np.sin(angle)).ravel()], axis=1)
    number = np.arange(len(vertices)).reshape(radius.shape)
    a, b, c, d = (n.ravel() for n in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]))
    triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    triangles = np.concatenate([triangles, triangles + len(vertices)]).astype(np.int32)
    flat = np.concatenate([vertices, vertices + np.array([3.0, 0.0])])
    edges, edge_triangles = list_edges(triangles, len(flat))
    letters = np.where(edge_triangles[:, 1] < 0, "B", "F")
    none = np.full((len(flat), 2), -1)
    mesh = assemble_mesh(flat, triangles, edges, edge_triangles, letters, np.arange(len(flat)), none)
    # turned, so that no face lies along an axis
    turn = np.array([[0.8, 0.0, 0.6], [0.36, 0.8, -0.48], [-0.48, 0.6, 0.64]])
    stowed = np.concatenate([np.pad(vertices, ((0, 0), (0, 1))), np.pad(vertices, ((0, 0), (0, 1)))])
    stowed[len(vertices) :, 2] = 2e-5
    return mesh, stowed @ turn


def measure_graded(around: int) -> dict[str, float]:
    """Searches on one size of the graded mesh, within 20 um: the smallest elements are 30 um to 0.5 mm."""
    mesh, stowed = graded_mesh(around)
    coordinates, submesh = number_coordinates(mesh), build_submesh(mesh, 1)
    points = build_points(mesh, coordinates, submesh, "mixed", 4)
    positions = points.interpolation @ affine_coordinates(mesh, coordinates, stowed)
    nodes, slaves = positions[: points.node_count], positions[points.node_count :]
    search, clock, radius = Search(points, submesh, 0.1, "cpu"), Clock(), 2e-5
    arrays = [wp.array(x, dtype=vec3, device="cpu") for x in (slaves, nodes)]
    features = FeatureSearch(submesh_features(mesh, coordinates, submesh), "cpu")
    row, phases = {"elements": len(mesh.triangles)}, Counter()
    row["point_search"], parts, found = clock.median(lambda: search.within(*arrays, radius))
    phases.update(parts)
    row["feature_search"], parts, near = clock.median(lambda: features.within(nodes, radius))
    phases.update(parts)
    row |= {f"search_{name}": phases[name] for name in PHASES}
    row["search"] = row["point_search"] + row["feature_search"]
    row |= {"point_search_pairs": len(found.candidates), "feature_search_pairs": len(near.distances)}
    return row | {"sub_triangles": len(submesh.triangles), "slave_points": points.slave_count}


def count_searches(until: float) -> list[dict[str, object]]:
    """Searches, evaluations of contact and their seconds in a run of leaf_in, set-up included."""
    counts, seconds = Counter(), Counter()
    classes = {"points": Search, "edges": EdgeSearch, "features": FeatureSearch}
    methods = [(name, kind, "within") for name, kind in classes.items()]
    methods += [("layers of pairs that met within a step", Search, "nearest")]
    methods += [("evaluations of surfaces", SurfaceContact, "_evaluate")]
    for name, kind, method in methods:
        call = getattr(kind, method, None)
        if call is None:
            continue

        def counted(self, *arguments, call=call, name=name):
            start = time.process_time()
            result = call(self, *arguments)
            counts[name] += 1
            seconds[name] += time.process_time() - start
            return result

        setattr(kind, method, counted)
    start = time.process_time()
    summary = warp_origami.simulate(warp_origami.load_scene("leaf_in"), device="cpu", until=until).summary
    counts["steps, accepted and rejected"] = summary["steps_accepted"] + summary["steps_rejected"]
    seconds["steps, accepted and rejected"] = time.process_time() - start
    return [{"what": name, "number": counts[name], "seconds": round(seconds[name], 3)} for name in counts]


def write(name: str, rows: list[dict]) -> None:
    """One CSV with all the columns of the rows."""
    columns = list(dict.fromkeys(key for row in rows for key in row))
    with open(RESULTS / name, "w", newline="") as file:
        writer = csv.DictWriter(file, columns)
        writer.writeheader()
        writer.writerows(
            {key: f"{value:.4g}" if isinstance(value, float) else value for key, value in row.items()} for row in rows
        )


def exponent(rows: list[dict], key: str, above: int = 0) -> float:
    """Slope of log(key) over log(elements) of more than `above` elements."""
    x, y = np.array([(row["elements"], row[key]) for row in rows if row["elements"] > above]).T
    return float(np.polyfit(np.log(x), np.log(y), 1)[0])


def draw(rows: list[dict]) -> None:
    """Seconds over elements, and seconds per 1000 elements."""
    figure, axes = plt.subplots(1, 2, figsize=(11.5, 4.8), layout="constrained")
    curves = [
        ("stack", "search", "search, all three", "C0o-"),
        ("stack", "point_search", "  points near faces", "C0s:"),
        ("stack", "feature_search", "  vertices, edges, facets", "C0^:"),
        ("stack", "narrow_phase", "narrow phase of points", "C2o-"),
        ("stack", "rest_of_evaluation", "rest of one evaluation", "C4o-"),
        ("stack", "setup", "set-up of contact", "C3o-"),
        ("divided", "search", "search, divided elements", "C0o--"),
        ("film", "search", "search, film of 0.5 mm", "C7o--"),
        ("graded", "search", "search, graded 1000 : 1", "C1o-"),
    ]
    for series, key, label, style in curves:
        chosen = [row for row in rows if row["series"] == series]
        elements, seconds = (np.array([row[name] for row in chosen]) for name in ("elements", key))
        label = f"{label}: {exponent(chosen, key, FIXED_COST):.2f}"
        axes[0].loglog(elements, seconds, style, label=label, markersize=4, linewidth=1.2)
        axes[1].loglog(elements, 1e3 * seconds / elements, style, markersize=4, linewidth=1.2)
    x = np.array([40.0, 6e4])
    axes[0].loglog(x, 2e-6 * x, "k-", linewidth=0.6)
    axes[0].annotate("linear", (60.0, 2e-4), fontsize=8, rotation=38)
    axes[0].set_ylabel("CPU seconds")
    axes[1].set_ylabel("CPU seconds per 1000 elements")
    for axis in axes:
        axis.set_xlabel("elements")
        axis.grid(True, which="major", linewidth=0.4)
    handles, labels = axes[0].get_legend_handles_labels()
    title = f"exponent above {FIXED_COST} elements"
    figure.legend(handles, labels, loc="outside right center", fontsize=8, title=title, title_fontsize=8)
    figure.savefig(RESULTS / "broadphase.png", dpi=110)


def main() -> None:
    """Measures, prints and writes everything."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--until", type=float, default=0.7, help="time (s) to which leaf_in runs to count its searches")
    parser.add_argument("--one", nargs=2, metavar=("SERIES", "SIZE"), help="measure one size and print it as JSON")
    options = parser.parse_args()
    wp.config.quiet = True
    if options.one:
        series, size = options.one[0], int(options.one[1])
        if series == "graded":
            row = measure_graded(size)
        else:
            row = measure_stack(size, FILM if series == "film" else None, 1 if series == "stack" else None)
        print(json.dumps(row))
        return
    rows = []
    for series, sizes in SIZES.items():
        for size in sizes:
            command = [sys.executable, __file__, "--one", series, str(size)]
            output = subprocess.run(command, check=True, capture_output=True, text=True).stdout
            row = {"series": series, **json.loads(output.splitlines()[-1])}
            row["search_per_1000"] = 1e3 * row["search"] / row["elements"]
            rows.append(row)
            pairs = sum(row.get(f"{name}_pairs", 0) for name in SEARCHES) / row["elements"]
            print(
                f"{series:7} {row['elements']:6d} elements  search {row['search']:.4f} s,"
                f" {row['search_per_1000']:.4f} s per 1000, {pairs:.1f} pairs per element",
                flush=True,
            )
    for series in SIZES:
        chosen = [row for row in rows if row["series"] == series]
        for key in ("search", "narrow_phase", "rest_of_evaluation", "setup"):
            if key in chosen[0]:
                above = f"above {FIXED_COST} elements {exponent(chosen, key, FIXED_COST):.2f}"
                print(f"{series:7} {key:19} exponent {exponent(chosen, key):.2f}, {above}")
    RESULTS.mkdir(exist_ok=True)
    write("broadphase.csv", rows)
    draw(rows)
    if options.until > 0.0:
        searches = count_searches(options.until)
        write("broadphase_run.csv", searches)
        for row in searches:
            print(f"{row['number']:6d} {row['what']}: {row['seconds']} s")


if __name__ == "__main__":
    main()
