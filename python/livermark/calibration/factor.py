"""Cholesky factors of symmetric matrices with a narrow envelope. Needs scipy.

SuperLU, which scipy has, takes several times as long for the stiffness of a body with a nodal volume, whose rows are
long: it is an LU factorisation, and in small pieces.
"""
from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy
from scipy.linalg import cholesky, solve_triangular

if TYPE_CHECKING:
    from numpy.typing import NDArray

BLOCK = 192  #: rows that are worked on at once


def along_the_longest_axis(points: NDArray[numpy.float64]) -> NDArray[numpy.int64]:
    """Numbers of points (N, 3) in an order in which neighbours are near each other."""
    return numpy.argsort(points[:, numpy.argmax(numpy.ptp(points, axis=0))], kind="stable")


class EnvelopeCholesky:
    """A = L L^T by rows of blocks: of each row what is left of its first entry stays zero.

    matrix: symmetric of scipy.sparse, in the order in which it is to be factorised. Raises numpy.linalg.LinAlgError if it is
    not positive definite.
    """

    def __init__(self, matrix: Any):
        rows = matrix.tocsr()
        self._size = rows.shape[0]
        self._first: list[int] = []  # of each row of blocks, the first column
        self._panels: list[NDArray[numpy.float64]] = []  # of each, L left of the diagonal block
        self._diagonal: list[NDArray[numpy.float64]] = []
        for begin in range(0, self._size, BLOCK):
            self._append(rows[begin:begin + BLOCK], begin)

    def _append(self, rows: Any, begin: int) -> None:
        first = min(int(rows.indices.min(initial=begin)), begin) // BLOCK * BLOCK
        panel = rows[:, first:begin].toarray()
        for j in range(first // BLOCK, begin // BLOCK):
            start, stop = max(first, self._first[j]), j * BLOCK
            block = panel[:, stop - first:stop - first + BLOCK]
            block -= panel[:, start - first:stop - first] @ self._panels[j][:, start - self._first[j]:].T
            block[:] = solve_triangular(self._diagonal[j], block.T, lower=True, check_finite=False).T
        diagonal = rows[:, begin:begin + BLOCK].toarray() - panel @ panel.T
        self._first.append(first)
        self._panels.append(panel)
        self._diagonal.append(cholesky(diagonal, lower=True, check_finite=False))

    def solve(self, columns: NDArray[numpy.float64]) -> NDArray[numpy.float64]:
        """A^-1 of columns, shape (size, C)."""
        found = numpy.array(columns)
        places = [slice(begin, begin + BLOCK) for begin in range(0, self._size, BLOCK)]
        rows = list(zip(places, self._first, self._panels, self._diagonal))
        for place, first, panel, diagonal in rows:
            found[place] -= panel @ found[first:place.start]
            found[place] = solve_triangular(diagonal, found[place], lower=True, check_finite=False)
        for place, first, panel, diagonal in reversed(rows):
            found[place] = solve_triangular(diagonal, found[place], lower=True, trans="T", check_finite=False)
            found[first:place.start] -= panel.T @ found[place]
        return found
