"""Volumes of tetrahedra, and the weights of norms over their nodes. Needs numpy alone."""
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
