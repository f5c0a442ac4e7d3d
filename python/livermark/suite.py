"""What the suite can do, with deal.II behind it, which is loaded by the first call."""
from __future__ import annotations

import json
import math
import os
import pathlib
import sys
from typing import TYPE_CHECKING, Any, Optional, Sequence, Union

from livermark.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from livermark._suite import CutBody, Problem, Score, Solution

Path = Union[str, "os.PathLike[str]"]


def lack_of(module: str) -> str:
    """Why an extension module of the package is not found, and the remedy."""
    folder = pathlib.Path(__file__).parent
    others = sorted(folder.glob(f"{module}.*.so"))
    version = ".".join(map(str, sys.version_info[:2]))
    if others:
        return (f"{others[0].name} is for another interpreter than {sys.executable} (Python {version}); start /usr/bin/python3, or "
                "build with -DPython_EXECUTABLE of that one")
    return (f"{folder} has no compiled part; in the source tree run scripts/bootstrap --program, and set PYTHONPATH to its "
            "build/release/python (docs/reference/python.md)")


def load():
    """The extension module. An installed package has the bodies and load cases in its folder data/."""
    data = pathlib.Path(__file__).resolve().parent / "data"
    if data.is_dir():
        os.environ.setdefault("LIVERMARK_ROOT", str(data))
    try:
        from livermark import _suite
    except ImportError as error:
        raise ImportError("the suite with its finite elements is not here: install python3-livermark-suite, or build with "
                          f"-DLIVERMARK_WITH_FEM_REFERENCE=ON; {lack_of('_suite')} ({error})") from error
    return _suite


def bodies() -> list[str]:
    """Names of the bodies that ship."""
    return load().bodies()


def load_cases() -> list[str]:
    """Names of the load cases that ship."""
    return load().load_cases()


def models() -> list[str]:
    """Names of the models."""
    return load().models()


def problem(body: Path, load_case: Path, young_modulus: Optional[float] = None,
            poisson_ratio: Optional[float] = None) -> Problem:
    """A body under a load case, with the loads scaled to their target.

    body: one of bodies(), or the path of a .toml or mesh file. load_case: one of load_cases(), or the path of a .toml.
    young_modulus [Pa]: of the first region, others keep their ratio to it. poisson_ratio: of every region.
    Raises InputError.
    """
    return load().problem(os.fspath(body), os.fspath(load_case), young_modulus, poisson_ratio)


def cut(body: Path, region: Optional[str] = None, margin: Optional[float] = None, *,
        half_space: Optional[ArrayLike] = None, blade: Optional[ArrayLike] = None, thickness: Optional[float] = None,
        way: str = "facets", small_pieces: str = "refuse", output: Optional[Path] = None) -> CutBody:
    """A body without what a knife takes away; its new surface is the patch "wound".

    body: one of bodies(), or the path of a .toml or mesh file. One of: region, with a margin [m] around it; half_space,
    shape (2, 3), a point of a plane [m] and the normal that points to what goes; blade, shape (4, 3), the corners in turn
    of what a straight blade sweeps [m], with its thickness [m], of which 0 parts the body. way: "facets", whole tetrahedra
    go, or "exact", tetrahedra are split at the surface. small_pieces: "refuse", "remove", or "keep" as bodies of their
    own. output: path of a .msh file to write, with a .toml beside it, which problem() takes. Raises InputError.
    """
    path = None if output is None else os.fspath(output)
    return load().cut(os.fspath(body), region, margin, _numbers("half_space", half_space), _numbers("blade", blade),
                      thickness, way, small_pieces, path)


def _numbers(name: str, values: Optional[ArrayLike]) -> list[float]:
    import numpy
    if values is None:
        return []
    try:
        return numpy.asarray(values, dtype=float).ravel().tolist() or [math.nan]
    except (TypeError, ValueError):
        raise InputError(f"{name}: these are no numbers; give coordinates in m") from None


FINGERTIP_RADIUS = 0.012  #: [m], as livermark::studies::fingertip_radius has it
SOFT_LIVER = {"young_modulus": 5000.0, "poisson_ratio": 0.45, "density": 1060.0}  #: what a mesh alone is taken to be of


def advise(body: Any, young_modulus: Optional[ArrayLike] = None, poisson_ratio: Optional[ArrayLike] = None,
           density: Optional[ArrayLike] = None, *, tool_radius: float = FINGERTIP_RADIUS,
           budget: Optional[float] = None) -> dict[str, Any]:
    """What `livermark advise` says of a body: what it is, springs for touch and for position, steps, cost, caveats.

    body: one of bodies(), the path of a .toml or mesh file, or what has points (N, 3) [m] and tetrahedra (M, 4), such as
    from_meshio() returns. young_modulus [Pa], poisson_ratio, density [kg/m^3]: of a file as in problem(), and no density;
    of arrays numbers or (M), soft liver where left out. tool_radius: of what touches the body [m]. budget: processor time
    for a frame of 1/60 s [s]; models that take longer are not ranked. Returns the object of `livermark advise --json`, in
    SI units; docs/reference/advice.md has its keys. Raises InputError.
    """
    if not (isinstance(tool_radius, (int, float)) and 0.0 < tool_radius < 1.0):
        raise InputError(f"tool_radius: {tool_radius!r}; it has to be a length in metres, above 0 and below 1")
    if budget is not None and not (isinstance(budget, (int, float)) and 0.0 < budget < float("inf")):
        raise InputError(f"budget: {budget!r}; it has to be a positive number of seconds")
    if isinstance(body, (str, os.PathLike)):
        if density is not None:
            raise InputError("density: a file has its own; put it into a body .toml")
        return json.loads(load()._advise_on_file(os.fspath(body), young_modulus, poisson_ratio, tool_radius, budget))
    if not (hasattr(body, "points") and hasattr(body, "tetrahedra")):
        raise InputError("body: this is no name, no path, and has no points and tetrahedra; give one of them")
    given = {"young_modulus": young_modulus, "poisson_ratio": poisson_ratio, "density": density}
    material = {name: SOFT_LIVER[name] if value is None else value for name, value in given.items()}
    return json.loads(load()._advise_on_arrays(body.points, body.tetrahedra, **material, tool_radius=tool_radius,
                                              budget=budget, is_material_assumed=young_modulus is None))


def solve(body: Path, load_case: Path, model: str) -> Solution:
    """What a model finds for a load case on a body: problem(body, load_case).solve(model)."""
    return problem(body, load_case).solve(model)


def score(displacement: ArrayLike, body: Path, load_case: Path, name: str = "mine", models: Sequence[str] = ("fem_p1",),
          *, reference_on_mesh: bool = False, output: Optional[Path] = None, with_uncertainty: None = None) -> Score:
    """How far displacements of the nodes are from the reference, which is solved.

    displacement: (N, 3) [m], at the nodes of problem(body, load_case).points. name: of the model. models: to compare
    beside it. reference_on_mesh: compare with the reference on the mesh itself, not on refined meshes: quicker, but its
    own error stays unknown. output: path of a result file to write. with_uncertainty: is refused, it was the opposite of
    reference_on_mesh. Raises InputError.
    """
    path = None if output is None else os.fspath(output)
    return problem(body, load_case).score(displacement, name, list(models), reference_on_mesh=reference_on_mesh,
                                          output=path, with_uncertainty=with_uncertainty)
