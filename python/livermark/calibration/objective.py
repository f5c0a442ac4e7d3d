"""How far springs are from given solutions, and in which direction that falls. Needs scipy."""
from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Callable, NamedTuple, Optional

import numpy
import scipy.sparse
from scipy.optimize import minimize
from scipy.sparse.linalg import splu

from livermark.calibration.loads import Expected

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from livermark._livermark import Springs

WIDEST = 100.0  #: a spring may become so many times softer or stiffer than it was
MEMORY = 20  #: pairs of vectors of L-BFGS-B
FIRST_CHANGE = 0.1  #: of ln k in the first step of a round, at most


class State(NamedTuple):
    """What some stiffnesses are worth."""
    value: float  #: J; infinity where the body is not stiff in every direction
    gradient: NDArray[numpy.float64]  #: (S) dJ/d ln k
    errors: NDArray[numpy.float64]  #: (L) relative L2 error under each load


class Objective:
    """J of livermark.calibrate().

    springs: with the stiffnesses k0 to start from, at whose rest points the body is linearised. expected: L loads.
    volume: (N) of each node [m^3]. held_out: (L) bool, loads that are no part of J. penalty: at least 0.
    """

    def __init__(self, springs: Springs, expected: Expected, volume: NDArray[numpy.float64],
                 held_out: NDArray[numpy.bool_], penalty: float):
        size = expected.fixed.size
        free = numpy.flatnonzero(~expected.fixed)
        rows, columns, values = springs.tangent(springs.points)
        tangent = scipy.sparse.csc_matrix((values, (rows, columns)), shape=(size, size))
        self.start = numpy.log(springs.stiffness)  #: (S) ln k0
        self._start_stiffness = springs.stiffness
        self._tangent = tangent[:, free][free]
        self._extension = _extension_matrix(springs, size)[:, free].tocsr()
        self._volume = numpy.repeat(volume, 3)[free][:, None]
        self._force = expected.force.reshape(len(held_out), size)[:, free].T
        self._wanted = expected.displacement.reshape(len(held_out), size)[:, free].T
        self._wanted_square = (self._volume * self._wanted**2).sum(axis=0)
        self._training = ~held_out
        self._penalty = penalty

    def evaluate(self, log_stiffness: NDArray[numpy.float64]) -> State:
        """At ln k, shape (S) with k in N/m: a factorisation, a solve for each load and one more for each training load."""
        stiffness = numpy.exp(log_stiffness)
        change = scipy.sparse.diags(stiffness - self._start_stiffness)
        solve = solver((self._tangent + self._extension.T @ change @ self._extension).tocsc())
        if solve is None:
            return State(math.inf, numpy.zeros_like(stiffness), numpy.full(len(self._training), math.nan))
        displacement = solve(self._force)
        difference = displacement - self._wanted
        errors = numpy.sqrt((self._volume * difference**2).sum(axis=0) / self._wanted_square)
        ratio = log_stiffness - self.start
        value = (errors[self._training]**2).mean() + self._penalty * (ratio**2).mean()

        training = self._training
        slope = 2.0 / training.sum() * self._volume * difference[:, training] / self._wanted_square[training]
        adjoint = solve(slope)
        work = ((self._extension @ displacement[:, training]) * (self._extension @ adjoint)).sum(axis=1)
        gradient = 2.0 * self._penalty / len(ratio) * ratio - stiffness * work
        return State(float(value), gradient, errors)


def solver(matrix: Any) -> Optional[Callable[[NDArray[numpy.float64]], NDArray[numpy.float64]]]:
    """X = A^-1 B of a symmetric matrix A; nothing if A is not positive definite, so that a pivot is not positive."""
    try:
        factors = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError:  # a pivot is zero
        return None
    return factors.solve if (factors.U.diagonal() > 0.0).all() else None


def _extension_matrix(springs: Springs, size: int) -> Any:
    """(S, 3N), row s is b_s: displacements to the extension of spring s."""
    edges = springs.edges.astype(int)
    direction = springs.points[edges[:, 1]] - springs.points[edges[:, 0]]
    direction /= numpy.linalg.norm(direction, axis=1)[:, None]
    row = numpy.repeat(numpy.arange(len(edges)), 6)
    column = (3 * edges[:, :, None] + numpy.arange(3)).reshape(len(edges), 6)
    values = numpy.hstack([-direction, direction])
    return scipy.sparse.csc_matrix((values.ravel(), (row, column.ravel())), shape=(len(edges), size))


class _RoundIsOver(Exception):
    pass


def calibration_round(objective: Objective, stiffness: NDArray[numpy.float64], num_evaluations: int,
                      observe: Callable[[State], None] = lambda state: None, widest: float = WIDEST,
                      ) -> tuple[NDArray[numpy.float64], NDArray[numpy.float64]]:
    """Minimises J by L-BFGS-B (Byrd, Lu, Nocedal and Zhu 1995), with every k between k0 / widest and k0 widest.

    stiffness: (S) [N/m], where it begins. num_evaluations: of J, at most. observe: called with each of them.
    Returns the best stiffnesses that were met, (S) [N/m], and their errors, (L).
    """
    lower, upper = objective.start - math.log(widest), objective.start + math.log(widest)
    best, best_point = State(math.inf, numpy.empty(0), numpy.empty(0)), numpy.log(stiffness)
    evaluations, scale = 0, 1.0

    def scaled(point: NDArray[numpy.float64]) -> tuple[float, NDArray[numpy.float64]]:
        nonlocal best, best_point, evaluations, scale
        if evaluations == num_evaluations:
            raise _RoundIsOver
        state = objective.evaluate(point)
        evaluations += 1
        observe(state)
        if not math.isfinite(state.value):
            raise _RoundIsOver
        if state.value < best.value:
            best, best_point = state, point.copy()
        largest = abs(state.gradient).max()
        if evaluations == 1 and largest > 0.0:  # the first step is the negative gradient
            scale = FIRST_CHANGE / largest
        return scale * state.value, scale * state.gradient

    # A stiffness at its bound may be beyond it by the rounding of the logarithm.
    begin = numpy.clip(numpy.log(stiffness), lower, upper)
    try:
        minimize(scaled, begin, jac=True, method="L-BFGS-B", bounds=numpy.column_stack([lower, upper]),
                 options={"maxcor": MEMORY, "maxfun": 2 * num_evaluations, "ftol": 0.0, "gtol": 0.0})
    except _RoundIsOver:
        pass
    return numpy.exp(best_point), best.errors
