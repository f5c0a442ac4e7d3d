"""Quasi-random points and Sobol indices, by OpenTURNS.

The indices are those of a sparse polynomial chaos: of the Legendre polynomials up to the largest total degree that has no
more terms than there are points, least angle regression keeps those that lower the corrected leave-one-out error (Blatman
and Sudret 2011, J. Comput. Phys. 230), and the squares of their coefficients are parts of the variance (Sudret 2008, Reliab.
Eng. Syst. Saf. 93). Intervals are of points drawn again with replacement, for the terms that were kept.
"""
import math

import numpy as np
import openturns as ot

ot.Log.Show(ot.Log.NONE)
NUM_DRAWS = 400
LEVELS = (2.5, 97.5)  # of the intervals [%]


def unit_cube(dimension):
    return ot.ComposedDistribution([ot.Uniform(0.0, 1.0)] * dimension)


def sobol_points(count, dimension):
    """(count, dimension) of Sobol's sequence in the unit cube: more of them begin with the same ones."""
    experiment = ot.LowDiscrepancyExperiment(ot.SobolSequence(dimension), unit_cube(dimension), count, False)
    return np.array(experiment.generate())


def largest_degree(count, dimension):
    """The largest total degree of which there are no more polynomials than points; 1 at least."""
    degree = 1
    while math.comb(dimension + degree + 1, dimension) <= count:
        degree += 1
    return degree


class Chaos:
    """A sparse polynomial chaos of one output. Indices are summed here: OpenTURNS 1.20 takes the first term for the
    constant in total indices, and a sparse chaos of values around 0 may have none.

    @param points  (S, P) in the unit cube
    @param values  (S)
    """

    def __init__(self, points, values):
        count, dimension = points.shape
        degree = largest_degree(count, dimension)
        enumeration = ot.LinearEnumerateFunction(dimension)
        basis = ot.OrthogonalProductPolynomialFactory([ot.LegendreFactory()] * dimension, enumeration)
        terms = ot.FixedStrategy(basis, math.comb(dimension + degree, dimension))
        selection = ot.LeastSquaresMetaModelSelectionFactory(ot.LARS(), ot.CorrectedLeaveOneOut())
        sample = ot.Sample(values[:, None].tolist())
        algorithm = ot.FunctionalChaosAlgorithm(ot.Sample(points.tolist()), sample, unit_cube(dimension), terms,
                                                ot.LeastSquaresStrategy(selection))
        algorithm.run()
        result = algorithm.getResult()
        self.values = values
        self.exponents = np.array([list(enumeration(i)) for i in result.getIndices()]).reshape(-1, dimension)
        inputs = result.getTransformation()(ot.Sample(points.tolist()))
        self.matrix = np.column_stack([np.array(term(inputs))[:, 0] for term in result.getReducedBasis()])
        self.coefficients = np.array(result.getCoefficients())[:, 0]

    def parts(self, coefficients, inside):
        """The part of the variance of the terms that `inside` says yes to; 0 where nothing varies."""
        varies = self.exponents.any(axis=1)
        variance = (coefficients[varies] ** 2).sum()
        return (coefficients[varies & inside] ** 2).sum() / variance if variance > 0.0 else 0.0

    def first(self, coefficients, parameter):
        others = np.delete(self.exponents, parameter, axis=1)
        return self.parts(coefficients, ~others.any(axis=1))

    def total(self, coefficients, parameters):
        """Of a group of parameters together: all terms that any of them is in."""
        return self.parts(coefficients, self.exponents[:, parameters].any(axis=1))

    def unexplained(self):
        """Mean square leave-one-out error over the variance of the values."""
        variance = self.values.var()
        if variance == 0.0:
            return 0.0
        inverse = np.linalg.pinv(self.matrix)
        residual = self.values - self.matrix @ (inverse @ self.values)
        leverage = np.clip((self.matrix * inverse.T).sum(axis=1), 0.0, 1.0 - 1e-9)
        return float(np.mean((residual / (1.0 - leverage)) ** 2) / variance)

    def draws(self):
        """(NUM_DRAWS, terms) coefficients of points drawn again; the same at every call."""
        random = np.random.default_rng(1)
        count = len(self.values)
        for _ in range(NUM_DRAWS):
            rows = random.integers(count, size=count)
            yield np.linalg.lstsq(self.matrix[rows], self.values[rows], rcond=None)[0]


def sobol_indices(points, values, groups):
    """Estimates the indices of one output for independent parameters that are uniform in the unit cube.

    points: (S, P), S > P. values: (S) finite. groups: (G) lists of numbers of parameters. Returns first, first_lower,
    first_upper, total, total_lower, total_upper (P each), group_total (G) and unexplained, the part of the variance that
    the polynomial misses.
    """
    points, values = np.asarray(points, dtype=float), np.asarray(values, dtype=float)
    parameters = range(points.shape[1])
    if np.ptp(values) <= 1e-12 * np.abs(values).max():  # nothing varies: no polynomial, no index
        return {name: [0.0] * len(parameters) for name in ("first", "first_lower", "first_upper", "total", "total_lower",
                                                           "total_upper")} | {"group_total": [0.0] * len(groups),
                                                                              "unexplained": 0.0}
    chaos = Chaos(points, (values - values.mean()) / values.std())
    drawn = list(chaos.draws())
    first = np.percentile([[chaos.first(c, p) for p in parameters] for c in drawn], LEVELS, axis=0)
    total = np.percentile([[chaos.total(c, [p]) for p in parameters] for c in drawn], LEVELS, axis=0)
    return {"first": [float(chaos.first(chaos.coefficients, p)) for p in parameters],
            "first_lower": first[0].tolist(), "first_upper": first[1].tolist(),
            "total": [float(chaos.total(chaos.coefficients, [p])) for p in parameters],
            "total_lower": total[0].tolist(), "total_upper": total[1].tolist(),
            "group_total": [float(chaos.total(chaos.coefficients, group)) for group in groups],
            "unexplained": chaos.unexplained()}
