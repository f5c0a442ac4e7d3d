"""Stiffnesses of springs that are fitted to finite elements on the same mesh, for `livermark run --calibration`."""
from __future__ import annotations

import os
import pathlib
from typing import Callable, Optional, Union

import numpy

from livermark.calibration.files import Calibration, begin, check_place, read, refuse_another, write
from livermark.calibration.loads import check_patch, disc_loads, mesh_of, solved
from livermark.errors import InputError
from livermark.suite import load

__all__ = ["Calibration", "calibrate"]

HELD_OUT_STRIDE = 4  #: every so many loads one has no part in the fit
MOST_LOADS = 1000
ROUND_LENGTH = 20  #: after so many evaluations the file is written, and L-BFGS-B begins anew
MOST_PENALTY = 1e6
PENALTY = 1e-3
SAME_LOADS = 1e-6  #: relative difference of errors that two machines may find for the same loads

Path = Union[str, "os.PathLike[str]"]
Report = Callable[[str], None]


def calibrate(body: Path, *, law: str = "patch", constrained: str = "posterior", num_loads: int = 24, seed: int = 1,
              iterations: int = 100, penalty: float = PENALTY, young_modulus: Optional[float] = None,
              poisson_ratio: Optional[float] = None, output: Optional[Path] = None, restart: bool = False,
              report: Optional[Report] = None) -> Calibration:
    """Fits the stiffness of every spring of a body to finite elements under random loads.

    Each load pulls at a disc of the free surface of 15 to 30 mm radius, in a random direction, while a patch is
    constrained; every fourth load is held out. The body is linearised at rest, K(k) = sum of k_s b_s b_s^T + K_0 with K_0
    of the nodal volume, and the stiffnesses k minimise
        J = mean of e_l^2 + penalty * mean of (ln k_s / k0_s)^2,  e_l^2 = sum_i V_i |u_i - r_i|^2 / sum_i V_i |r_i|^2
    over ln k, each within 1/100 to 100 times its start k0, by L-BFGS-B with the gradient of the adjoint method (Givoli
    2021, Comput. Methods Appl. Mech. Engrg. 380, 113810). u is what the springs find under load l, r what finite elements
    find on the same mesh, V the volume of a node. Needs scipy and h5py.

    body, young_modulus [Pa], poisson_ratio: as of problem(). law: one of spring_laws(), for k0. constrained: a patch.
    num_loads: 4 to 1000. seed: of the loads, at least 0. iterations: evaluations of J, a multiple of 20, earlier calls
    included. penalty: the square of a ratio, of the error that is worth fitting to the change that is thought likely.
    output: path of the file to write after every 20 evaluations (results/schema.md, "Calibration files"); a file that is
    there is continued, or begun again with restart. report: called with lines of progress.
    Returns Calibration. Raises InputError.
    """
    _check(num_loads, seed, iterations, penalty)
    file = None if output is None else pathlib.Path(output)
    if file is not None:
        check_place(file)
    tell = report or (lambda line: None)
    mesh = mesh_of(body, young_modulus, poisson_ratio)
    check_patch(mesh, constrained)
    springs = _springs(mesh, law)
    held_out = numpy.arange(num_loads) % HELD_OUT_STRIDE == HELD_OUT_STRIDE - 1
    calibration = begin(mesh, springs, law, constrained, seed, penalty, held_out)
    if file is not None and file.exists() and not restart:
        earlier = read(file)
        refuse_another(earlier, calibration, file)
        calibration = earlier
    if calibration.iterations < iterations:
        loads = disc_loads(mesh, constrained, num_loads, seed)
        expected = solved(body, loads, constrained, young_modulus, poisson_ratio, calibration.reference, tell)
        _improve(calibration, _objective(springs, mesh, expected, calibration), iterations, file, tell)
    return calibration


def _check(num_loads: int, seed: int, iterations: int, penalty: float) -> None:
    def is_whole(value: object) -> bool:
        return isinstance(value, (int, numpy.integer)) and not isinstance(value, bool)

    if not (is_whole(num_loads) and HELD_OUT_STRIDE <= num_loads <= MOST_LOADS):
        raise InputError(f"num_loads: {num_loads!r}; give a whole number from {HELD_OUT_STRIDE} to {MOST_LOADS}")
    if not (is_whole(seed) and 0 <= seed < 2**63):
        raise InputError(f"seed: {seed!r}; give a whole number from 0 to 2^63 - 1")
    if not (is_whole(iterations) and iterations >= ROUND_LENGTH and iterations % ROUND_LENGTH == 0):
        raise InputError(f"iterations: {iterations!r}; give a multiple of {ROUND_LENGTH}")
    if not (isinstance(penalty, (int, float)) and 0.0 <= penalty <= MOST_PENALTY):
        raise InputError(f"penalty: {penalty!r}; give a number from 0 to {MOST_PENALTY:g}")


def _springs(mesh, law: str):
    from livermark import springs
    return springs(mesh.points, mesh.tetrahedra, mesh.young_modulus, mesh.poisson_ratio, law=law, density=mesh.density,
                   volume_term="nodal_volume")


def _objective(springs, mesh, expected, calibration: Calibration):
    try:
        from livermark.calibration.objective import Objective
    except ImportError as error:
        if (error.name or "").partition(".")[0] != "scipy":
            raise
        raise ImportError("this needs scipy; install python3-scipy") from error
    volume = numpy.zeros(len(mesh.points))
    corners = mesh.points[mesh.tetrahedra]
    sides = corners[:, 1:] - corners[:, :1]
    numpy.add.at(volume, mesh.tetrahedra, numpy.linalg.det(sides)[:, None] / 24.0)
    return Objective(springs, expected, volume, calibration.held_out, calibration.penalty)


def _improve(calibration: Calibration, objective, iterations: int, file: Optional[pathlib.Path], tell: Report) -> None:
    """Rounds until there were so many evaluations. Each begins without a memory of earlier ones, so that it does not
    matter which call runs it."""
    from livermark.calibration.objective import calibration_round
    before = objective.evaluate(objective.start)
    if not numpy.isfinite(before.value):
        raise InputError("the body is not stiff in every direction; constrain more facets, or take a Poisson's ratio of "
                         "1/4 or more")
    if calibration.iterations == 0:
        calibration.error_before = before.errors
    elif not numpy.allclose(before.errors, calibration.error_before, rtol=SAME_LOADS):
        raise InputError(f"{file}: was made with other loads, by another version; give restart, or another output")
    done = calibration.iterations

    def observe(state) -> None:
        nonlocal done
        done += 1
        training, others = (100.0 * state.errors[chosen].mean() for chosen in (~calibration.held_out, calibration.held_out))
        tell(f"[{done}/{iterations}] objective {state.value:.6f}, mean error {training:.2f} % in training, {others:.2f} % held out")

    while calibration.iterations < iterations:
        found = calibration_round(objective, calibration.stiffness, ROUND_LENGTH, observe)
        calibration.stiffness, calibration.error_after = found
        calibration.iterations += ROUND_LENGTH
        done = calibration.iterations
        if file is not None:
            write(file, calibration, load()._provenance)
