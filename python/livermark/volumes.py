"""Volumes of tetrahedra, the weights of norms over their nodes, and places in them. Needs numpy alone."""
from __future__ import annotations

import numpy
from numpy.typing import NDArray


def tetrahedron_volumes(points: NDArray[numpy.floating], corners: NDArray[numpy.integer]) -> NDArray[numpy.float64]:
    """(M) signed, for points (N, 3) [m] and node numbers (M, 4) [m^3]"""
    a, b, c, d = (points[corners[:, k]] for k in range(4))
    return numpy.einsum("ij,ij->i", numpy.cross(b - a, c - a), d - a) / 6.0


def nodal_volumes(points: NDArray[numpy.floating], corners: NDArray[numpy.integer]) -> NDArray[numpy.float64]:
    """(N) a quarter of each tetrahedron at a node [m^3]: the barycentric volumes of every relative_l2"""
    return numpy.bincount(corners.ravel(), numpy.repeat(tetrahedron_volumes(points, corners) / 4.0, 4), len(points))


def corner_weights(places: NDArray[numpy.floating], points: NDArray[numpy.floating], corners: NDArray[numpy.integer]
                   ) -> tuple[NDArray[numpy.int64], NDArray[numpy.float64]]:
    """The tetrahedron that holds each place, (V), and the weights of its corners there, (V, 4): barycentric coordinates. A place
    outside the body belongs to the tetrahedron that it is least outside of, and has a negative weight.

    Shapes: places (V, 3) and points (N, 3) [m], corners (M, 4)"""
    origin = points[corners[:, 0]]
    edges = numpy.stack([points[corners[:, k]] - origin for k in (1, 2, 3)], axis=2)
    to_weights = numpy.linalg.inv(edges)
    tetrahedron = numpy.zeros(len(places), dtype=numpy.int64)
    weights = numpy.zeros((len(places), 4))
    for v, place in enumerate(places):
        last = numpy.einsum("mij,mj->mi", to_weights, place - origin)
        first = 1.0 - last.sum(axis=1)
        best = int(numpy.argmax(numpy.minimum(first, last.min(axis=1))))
        tetrahedron[v], weights[v] = best, [first[best], *last[best]]
    return tetrahedron, weights
