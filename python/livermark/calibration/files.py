"""Calibration files: what results/schema.md has under "Calibration files". Needs h5py."""
from __future__ import annotations

import dataclasses
import os
import pathlib
import shlex
import sys
from typing import TYPE_CHECKING, Any, Callable, Optional

import numpy

from livermark.errors import InputError
from livermark.hdf5_files import FAULTS, SCHEMA_VERSION, new_hdf5, open_hdf5, put_attribute, put_dataset

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from livermark._livermark import Springs
    from livermark._suite import Problem

COMMAND = "python3 -m livermark.calibration"
REFERENCE = "fem_p2p1"  #: the reference of small loads, on the mesh itself
VOLUME_TERM = "nodal_volume"
ATTRIBUTES = {"body": "body", "spring_law": "spring_law", "volume_term": "volume_term", "reference": "reference",
              "constrained": "held", "seed": "seed", "iterations": "iterations", "penalty": "penalty"}  #: of the root
DATASETS = {"density": ("materials/density", "kg/m^3"), "young_modulus": ("materials/young_modulus", "Pa"),
            "poisson_ratio": ("materials/poisson_ratio", ""), "edges": ("springs/edges", ""),
            "rest_length": ("springs/rest_length", "m"), "start_stiffness": ("springs/start_stiffness", "N/m"),
            "stiffness": ("springs/stiffness", "N/m"), "held_out": ("loads/held_out", ""),
            "error_before": ("loads/error_before", ""), "error_after": ("loads/error_after", "")}


@dataclasses.dataclass
class Calibration:
    """Springs fitted to the solutions of another model, and how well. S springs, R regions, L loads."""
    body: str
    spring_law: str  #: the stiffnesses that it started from
    volume_term: str  #: what is beside the springs
    reference: str  #: the model whose solutions they were fitted to
    constrained: str  #: the patch where the body was constrained
    seed: int  #: of the random loads
    iterations: int  #: evaluations of the objective so far
    penalty: float  #: weight of the change of the stiffnesses
    density: NDArray[numpy.float64]  #: (R) [kg/m^3]
    young_modulus: NDArray[numpy.float64]  #: (R) [Pa]
    poisson_ratio: NDArray[numpy.float64]  #: (R)
    edges: NDArray[numpy.int64]  #: (S, 2) nodes that each spring joins
    rest_length: NDArray[numpy.float64]  #: (S) [m]
    start_stiffness: NDArray[numpy.float64]  #: (S) [N/m]
    stiffness: NDArray[numpy.float64]  #: (S) the best so far [N/m]
    held_out: NDArray[numpy.bool_]  #: (L) loads that have no part in the fit
    error_before: NDArray[numpy.float64]  #: (L) relative L2 error under each load, with start_stiffness
    error_after: NDArray[numpy.float64]  #: (L) the same with stiffness

    def table(self) -> str:
        """Means and maxima of the errors before and after, in Markdown."""
        lines = [f"{self.body}: relative L2 errors to {self.reference} after {self.iterations} iterations from "
                 f"{self.spring_law}", "",
                 "| loads | number | mean before [%] | worst before [%] | mean after [%] | worst after [%] |",
                 "| --- | ---: | ---: | ---: | ---: | ---: |"]
        for name, chosen in (("training", ~self.held_out), ("held out", self.held_out)):
            numbers = [f"{100.0 * value:.2f}" for errors in (self.error_before[chosen], self.error_after[chosen])
                       for value in (errors.mean(), errors.max())]
            lines.append(f"| {name} | {chosen.sum()} | " + " | ".join(numbers) + " |")
        return "\n".join(lines)


def begin(mesh: Problem, springs: Springs, law: str, constrained: str, seed: int, penalty: float,
          held_out: NDArray[numpy.bool_]) -> Calibration:
    """A calibration before its first iteration."""
    first = [int(numpy.argmax(mesh.region == region)) for region in range(len(mesh.region_names))]
    nothing = numpy.full(len(held_out), numpy.nan)
    return Calibration(mesh.body, law, VOLUME_TERM, REFERENCE, constrained, int(seed), 0, float(penalty),
                       mesh.density[first], mesh.young_modulus[first], mesh.poisson_ratio[first],
                       springs.edges.astype(numpy.int64), springs.rest_length.copy(), springs.stiffness.copy(),
                       springs.stiffness.copy(), held_out, nothing, nothing)


def check_place(file: pathlib.Path) -> None:
    """Raises InputError where no file can be written."""
    if file.exists() and not file.is_file():
        raise InputError(f"{file}: this is not a plain file; give the name of a file")
    if not file.parent.is_dir():
        raise InputError(f"{file}: there is no directory {file.parent}; make it or choose another place")
    if not os.access(file.parent, os.W_OK | os.X_OK):
        raise InputError(f"{file}: the directory {file.parent} cannot be written to; choose another place")


def write(file: pathlib.Path, calibration: Calibration, provenance: Callable[[str], dict[str, Any]]) -> None:
    """Puts a whole file in the place of an earlier one. Raises InputError if it cannot be written."""
    with new_hdf5(file, provenance(shlex.join(sys.argv))) as opened:
        for name, place in ATTRIBUTES.items():
            put_attribute(opened, place, getattr(calibration, name))
        for name, (place, units) in DATASETS.items():
            put_dataset(opened, place, getattr(calibration, name), units)


def read(file: pathlib.Path) -> Calibration:
    """What write() wrote. Raises InputError for another file."""
    with open_hdf5(file, COMMAND) as opened:
        try:
            if opened.attrs["schema_version"] != SCHEMA_VERSION:
                raise KeyError(f"schema version {opened.attrs['schema_version']}, and {SCHEMA_VERSION} is read here")
            found: dict[str, Any] = {name: opened.attrs[place] for name, place in ATTRIBUTES.items()}
            found = {name: value.decode() if isinstance(value, bytes) else value for name, value in found.items()}
            for name in ("seed", "iterations"):
                found[name] = int(found[name])
            arrays = {name: opened[place][:] for name, (place, _) in DATASETS.items()}
        except FAULTS as error:
            words = str(error.args[0] if error.args else error)
            raise InputError(f"{file}: this is no calibration ({words[:200]}); give another output, or restart") from None
    arrays["held_out"] = arrays["held_out"].astype(bool)
    calibration = Calibration(**found, **arrays)
    stiffness = calibration.stiffness
    if stiffness.shape != calibration.start_stiffness.shape or not (numpy.isfinite(stiffness) & (stiffness > 0.0)).all():
        raise InputError(f"{file}: the stiffnesses are not all positive and finite; give another output, or restart")
    return calibration


def refuse_another(earlier: Calibration, fresh: Calibration, file: Optional[pathlib.Path]) -> None:
    """Raises InputError if a file cannot be continued."""
    def differs(*names: str) -> bool:
        return not all(numpy.array_equal(getattr(earlier, name), getattr(fresh, name)) for name in names)

    if differs("edges", "rest_length"):
        raise InputError(f"{file}: was made for another mesh than that of {fresh.body}; give another output, or restart")
    if differs("young_modulus", "poisson_ratio"):
        raise InputError(f"{file}: was made for another Young's modulus or Poisson's ratio than that of {fresh.body}; give "
                         "another output, or restart")
    if differs("spring_law", "volume_term", "reference", "constrained", "seed", "penalty", "held_out", "start_stiffness"):
        raise InputError(f"{file}: was begun with another law, patch, seed, penalty or number of loads; give those again, "
                         "another output, or restart")
