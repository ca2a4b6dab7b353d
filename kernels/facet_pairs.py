"""Closest points of two features of the sub-triangles: a vertex and a triangle, or two edges.

    delta = sum_k w_k x_k       over the four corners of the pair; w > 0 on the first feature, < 0 on the second

The common normal n tells two states of a pair apart that lie on different sides: the distance has the sign of
n . delta. For a vertex, where delta is more along the triangle's normal than across it: over the triangle, and where
it lies over a corner, as in a stack of equal layers. For edges, n = e1 x e2, where they cross each other at an angle.
"""

import warp as wp

from .closest_point import closest_on_triangle
from .edge_curve import closest_on_segments
from .precision import real, vec3, vec4
from .swept import VERTEX_TRIANGLE, Features

HALF = wp.constant(real(0.5))
FLAT = wp.constant(real(1e-3))  # squared sine below which n turns over too easily
ALONG = wp.constant(real(0.5))  # cosine of the largest angle between delta and n


@wp.struct
class FacetPairs:
    """Kind (VERTEX_TRIANGLE, EDGE_EDGE) and numbers of the two features of each pair."""

    kinds: wp.array(dtype=wp.int32)
    firsts: wp.array(dtype=wp.int32)
    seconds: wp.array(dtype=wp.int32)


@wp.struct
class FacetDistances:
    """Of every pair.

    weights: w; distances: with their sign where it is known, m; normals: unit vector with delta = distance normal;
    facing: whether the sign is known.
    """

    weights: wp.array(dtype=vec4)
    distances: wp.array(dtype=real)
    normals: wp.array(dtype=vec3)
    facing: wp.array(dtype=wp.bool)


@wp.func
def write_distance(pair: int, weights: vec4, delta: vec3, normal: vec3, out: FacetDistances):
    """Distance and direction of a pair; `normal` is not of unit length, and zero where there is none."""
    length = wp.length(delta)
    n = wp.normalize(normal)
    height = wp.dot(n, delta)
    facing = wp.length_sq(normal) > real(0.0) and wp.abs(height) >= ALONG * length
    direction = n
    if length > real(0.0):
        direction = delta / length
    if facing and height < real(0.0):
        direction = -direction
        length = -length
    out.weights[pair] = weights
    out.distances[pair] = length
    out.normals[pair] = direction
    out.facing[pair] = facing


@wp.func
def vertex_on_triangle(pair: int, x: vec3, a: vec3, b: vec3, c: vec3, out: FacetDistances):
    """Vertex x and triangle abc."""
    at, _feature = closest_on_triangle(x, a, b, c)
    delta = x - (at[0] * a + at[1] * b + at[2] * c)
    weights = vec4(real(1.0), -at[0], -at[1], -at[2])
    write_distance(pair, weights, delta, wp.cross(b - a, c - a), out)


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
    crossing = s > zero and s < one and t > zero and t < one
    if not crossing or wp.length_sq(normal) <= FLAT * wp.length_sq(u) * wp.length_sq(v):
        normal = vec3()
    write_distance(pair, vec4(one - s, s, t - one, -t), (a + s * u) - (c + t * v), normal, out)


@wp.kernel(enable_backward=False)
def find_facet_distances(
    pairs: FacetPairs,
    features: Features,
    positions: wp.array(dtype=vec3),
    which: wp.array(dtype=wp.int32),
    begin: int,
    # out
    distances: FacetDistances,
):
    """Closest points of the pairs `which`."""
    pair = which[begin + wp.tid()]
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
