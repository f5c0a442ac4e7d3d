"""Vessels that are lines: tubes along straight segments, which move with the tissue around them. Needs numpy alone."""
from __future__ import annotations

import math
import os
from dataclasses import dataclass, replace
from typing import Any, Callable, Optional, Union

import numpy
from numpy.typing import NDArray

from livermark.volumes import corner_weights


@dataclass(frozen=True)
class Vessels:
    """As `/vessels` of a result file has them."""
    points: NDArray[numpy.float64]  #: (V, 3) of the axes [m]
    radius: NDArray[numpy.float64]  #: (V) outer [m]
    segments: NDArray[numpy.int64]  #: (W, 2) points that a tube joins

    @property
    def lengths(self) -> NDArray[numpy.float64]:
        """(W) [m]"""
        begin, end = self.points[self.segments].swapaxes(0, 1)
        return numpy.linalg.norm(end - begin, axis=1)

    @property
    def volume(self) -> float:
        """Of all tubes, whose radius is the mean of that of both ends, walls and blood together [m^3]."""
        return math.pi * float(self.radius[self.segments].mean(axis=1) ** 2 @ self.lengths)

    def moved(self, points: NDArray[numpy.float64], corners: NDArray[numpy.integer],
              displacement: NDArray[numpy.float64]) -> Vessels:
        """Where they are when the nodes (N, 3) of tetrahedra (M, 4) have moved by a displacement (N, 3): corner_weights()."""
        return self.mover(points, corners)(displacement)

    def mover(self, points: NDArray[numpy.float64],
              corners: NDArray[numpy.integer]) -> Callable[[NDArray[numpy.float64]], Vessels]:
        """moved() for many displacements of one mesh: weights are found once."""
        tetrahedron, weights = corner_weights(self.points, points, corners)
        nodes = corners[tetrahedron]
        return lambda displacement: replace(self, points=self.points + numpy.einsum("vc,vcd->vd", weights, displacement[nodes]))


def vessels_of(lines: Optional[dict[str, Any]]) -> Optional[Vessels]:
    """Of ResultFile.vessels; None of None"""
    return lines and Vessels(lines["points"], lines["radius"], lines["segments"])


def read_swc(path: Union[str, os.PathLike[str]]) -> Vessels:
    """Of a file that this program has written: its lengths are in metres."""
    with open(path, encoding="utf-8") as file:
        rows = numpy.array([line.split() for line in file if line.strip() and not line.startswith("#")], float)
    place = {int(number): row for row, number in enumerate(rows[:, 0])}
    segments = [(place[int(before)], row) for row, before in enumerate(rows[:, 6]) if before >= 0]
    return Vessels(rows[:, 2:5], rows[:, 5], numpy.array(segments, dtype=numpy.int64).reshape(-1, 2))


def swc_text(vessels: Vessels) -> str:
    """Such a file; each point ends one segment at most."""
    parent = numpy.full(len(vessels.points), -1)
    parent[vessels.segments[:, 1]] = vessels.segments[:, 0] + 1
    rows = zip(vessels.points.tolist(), vessels.radius.tolist(), parent.tolist())
    return "".join(f"{number} 0 {x:.9g} {y:.9g} {z:.9g} {radius:.9g} {before}\n"
                   for number, ((x, y, z), radius, before) in enumerate(rows, start=1))
