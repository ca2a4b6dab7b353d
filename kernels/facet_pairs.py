"""Closest points of two features of the sub-triangles: a vertex and a triangle, or two edges.

    delta = sum_k w_k x_k       over the four corners of the pair; w > 0 on the first feature, < 0 on the second

Inside both features delta is along their common normal n (of the triangle; e1 x e2 of the edges) and has a signed
height n . delta, by which two states of a pair are told apart that lie on different sides.
"""

import warp as wp

from .closest_point import INSIDE, closest_on_triangle
from .edge_curve import PARALLEL, closest_on_segments
from .precision import real, vec3, vec4
from .swept import VERTEX_TRIANGLE, Features

HALF = wp.constant(real(0.5))


@wp.struct
class FacetPairs:
    """Kind (VERTEX_TRIANGLE, EDGE_EDGE) and numbers of the two features of each pair."""

    kinds: wp.array(dtype=wp.int32)
    firsts: wp.array(dtype=wp.int32)
    seconds: wp.array(dtype=wp.int32)


@wp.struct
class FacetDistances:
    """Of every pair.

    weights: w; deltas: m; distances: |delta|, m; normals: n where the closest points lie inside both features, else the
    direction of delta; inside: whether they do.
    """

    weights: wp.array(dtype=vec4)
    deltas: wp.array(dtype=vec3)
    distances: wp.array(dtype=real)
    normals: wp.array(dtype=vec3)
    inside: wp.array(dtype=wp.bool)


@wp.func
def write_distance(pair: int, weights: vec4, delta: vec3, normal: vec3, inside: bool, out: FacetDistances):
    """Distance and direction of a pair; where edges are parallel there is no common normal."""
    length = wp.length(delta)
    out.weights[pair] = weights
    out.deltas[pair] = delta
    out.distances[pair] = length
    out.inside[pair] = inside
    direction = wp.normalize(normal)
    if not inside:
        direction = wp.normalize(delta)
    out.normals[pair] = direction


@wp.func
def vertex_on_triangle(pair: int, x: vec3, a: vec3, b: vec3, c: vec3, out: FacetDistances):
    """Vertex x and triangle abc."""
    at, feature = closest_on_triangle(x, a, b, c)
    delta = x - (at[0] * a + at[1] * b + at[2] * c)
    weights = vec4(real(1.0), -at[0], -at[1], -at[2])
    write_distance(pair, weights, delta, wp.cross(b - a, c - a), feature == INSIDE, out)


@wp.func
def edge_on_edge(pair: int, a: vec3, b: vec3, c: vec3, d: vec3, out: FacetDistances):
    """Edges ab and cd."""
    one = real(1.0)
    zero = real(0.0)
    u = b - a
    v = d - c
    at = closest_on_segments(a, u, c, v, HALF)
    s = at[0]
    t = at[1]
    normal = wp.cross(u, v)
    apart = wp.length_sq(normal) > PARALLEL * wp.length_sq(u) * wp.length_sq(v)  # else delta is not along the normal
    inside = s > zero and s < one and t > zero and t < one and apart
    write_distance(pair, vec4(one - s, s, t - one, -t), (a + s * u) - (c + t * v), normal, inside, out)


@wp.kernel(enable_backward=False)
def find_facet_distances(
    pairs: FacetPairs,
    features: Features,
    positions: wp.array(dtype=vec3),
    # out
    distances: FacetDistances,
):
    """Closest points of every pair."""
    pair = wp.tid()
    first = pairs.firsts[pair]
    second = pairs.seconds[pair]
    if pairs.kinds[pair] == VERTEX_TRIANGLE:
        a = positions[features.triangles[second, 0]]
        b = positions[features.triangles[second, 1]]
        c = positions[features.triangles[second, 2]]
        vertex_on_triangle(pair, positions[first], a, b, c, distances)
    else:
        a = positions[features.edges[first, 0]]
        b = positions[features.edges[first, 1]]
        c = positions[features.edges[second, 0]]
        d = positions[features.edges[second, 1]]
        edge_on_edge(pair, a, b, c, d, distances)
