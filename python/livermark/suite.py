"""What the suite can do, with deal.II behind it, which is loaded by the first call."""
from __future__ import annotations

import math
import os
import pathlib
from typing import TYPE_CHECKING, Optional, Sequence, Union

from livermark.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from livermark._suite import CutBody, Problem, Score, Solution

Path = Union[str, "os.PathLike[str]"]


def load():
    """The extension module. An installed package has the bodies and load cases in its folder data/."""
    data = pathlib.Path(__file__).resolve().parent / "data"
    if data.is_dir():
        os.environ.setdefault("LIVERMARK_ROOT", str(data))
    try:
        from livermark import _suite
    except ImportError as error:
        raise ImportError("the suite with its finite elements is not here: install python3-livermark-suite, or build "
                          f"with -DLIVERMARK_WITH_FEM_REFERENCE=ON ({error})") from error
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
