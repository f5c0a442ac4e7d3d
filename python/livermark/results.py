"""Result files of `livermark run` (results/schema.md), as numpy arrays and tables of pandas. Needs h5py alone."""
from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Optional, Union

from livermark.errors import InputError
from livermark.hdf5_files import open_hdf5, says_what_is_damaged

if TYPE_CHECKING:
    import numpy as np
    import pandas
    from numpy.typing import NDArray

SCHEMA_VERSION = 1


def _library(name: str, package: str):
    """A library that only some functions need."""
    try:
        return __import__(name)
    except ImportError as error:
        raise ImportError(f"this needs {name}; install {package}") from error


def _value(attribute: Any) -> Any:
    """Texts are bytes in HDF5, and numbers are scalars of numpy."""
    if isinstance(attribute, bytes):
        return attribute.decode(errors="replace")
    if hasattr(attribute, "dtype") and attribute.dtype.kind == "S":
        return [text.decode(errors="replace") for text in attribute]
    return attribute.item() if getattr(attribute, "ndim", 1) == 0 else attribute


def _attributes(group) -> dict[str, Any]:
    return {name: _value(value) for name, value in group.attrs.items()}


@says_what_is_damaged
class ModelResult:
    """What one model found, and how far that is from the reference. Arrays are read when they are asked for."""

    def __init__(self, file, name: str):
        self.name = name
        self._file = file
        self._solution = file["solutions"][name]
        self._comparison = file.get(f"comparisons/{name}")
        self.path = file.filename

    @property
    def is_open(self) -> bool:
        return bool(self._file)

    @property
    def attributes(self) -> dict[str, Any]:
        """status, message, degrees_of_freedom, solve_seconds, strain_energy and what else results/schema.md lists."""
        return _attributes(self._solution)

    @property
    def status(self) -> str:
        """ok, diverged or not_converged"""
        return self.attributes["status"]

    @property
    def displacement(self) -> NDArray[np.float64]:
        """(N, 3) [m], of a load case that depends on time the static start"""
        return self._solution["displacement"][:]

    @property
    def reaction(self) -> NDArray[np.float64]:
        """(P, 3) force of each constraint on the body [N], as in ResultFile.constraint_names"""
        return self._solution["reaction"][:]

    @property
    def springs(self) -> Optional[dict[str, NDArray]]:
        """edges (S, 2), stiffness (S) [N/m], rest_length (S) [m], node_mass (N) [kg]; None of finite elements"""
        if "edges" not in self._solution:
            return None
        return {name: self._solution[name][:] for name in ("edges", "stiffness", "rest_length", "node_mass")}

    @property
    def moves_in_steps(self) -> bool:
        """Whether it is made of springs, or moves in explicit steps."""
        return "edges" in self._solution or "critical_time_step" in self._solution.attrs

    @property
    def comparison(self) -> Optional[dict[str, Any]]:
        """reference, relative_l2, stiffness_at_tool, max_error [m], reaction_error and the rest; None of the reference"""
        return None if self._comparison is None else _attributes(self._comparison)

    @property
    def at_tool(self) -> Optional[dict[str, Any]]:
        """How wrong it is where the load case presses, pulls or moves a place: places, their names (G), as in
        ResultFile.tools; stiffness (G), force over displacement of the model over that of the reference, minus 1, positive
        is too stiff; relative_l2 (G), within two radii; path (L, G), stiffness along the path of loads, None in the small
        regime. None of the reference, without such a place, and of older files."""
        if self._comparison is None or "tool" not in self._comparison:
            return None
        tool = self._comparison["tool"]
        return {"places": _value(tool["stiffness"].attrs["places"]), "stiffness": tool["stiffness"][:],
                "relative_l2": tool["relative_l2"][:], "path": tool["path"][:] if "path" in tool else None}

    @property
    def error(self) -> Optional[NDArray[np.float64]]:
        """(N, 3) u - r [m]; None of the reference"""
        return self._comparison["error"][:] if self._comparison is not None and "error" in self._comparison else None

    @property
    def frames(self) -> Optional[NDArray[np.float32]]:
        """(F, N, 3) displacement in time, or along the path of loads [m]; None where nothing moved"""
        for place in ("history/frames", "path/displacement"):
            if place in self._solution:
                return self._solution[place][:].reshape(-1, len(self._file["mesh/points"]), 3)
        return None

    @property
    def has_history(self) -> bool:
        return "history" in self._solution

    def history(self) -> pandas.DataFrame:
        """Motion of the probes, a row for each record.

        index: time [s]. columns: "<probe> x", "<probe> y", "<probe> z" [m], kinetic_energy and strain_energy [J].
        """
        if not self.has_history:
            raise InputError(f"{self.name} has no motion; open the result of a load case with a release")
        history = self._solution["history"]
        probes = _value(self._file["load_case/release/probe"].attrs["names"])
        moved = history["displacement"][:]
        columns = {f"{probe} {axis}": moved[:, q, a] for q, probe in enumerate(probes) for a, axis in enumerate("xyz")}
        columns |= {name: history[name][:] for name in ("kinetic_energy", "strain_energy")}
        table = _library("pandas", "python3-pandas").DataFrame(columns, index=history["time"][:])
        table.index.name = "time"
        return table

    def __repr__(self) -> str:
        return f"<livermark.results.ModelResult {self.name}: {self.status}>"


@says_what_is_damaged
class ResultFile:
    """One body under one load case, solved by several models. Close it, or use it in a with statement."""

    def __init__(self, path: Union[str, os.PathLike[str]]):
        self.path = os.fspath(path)
        self._file = open_hdf5(self.path)
        self._check()

    def _check(self) -> None:
        version = self._file.attrs.get("schema_version")
        if version != SCHEMA_VERSION:
            self.close()
            raise InputError(f"{self.path}: the schema version is {version}, and {SCHEMA_VERSION} is read here; "
                             "make the file again with `livermark run`")
        if "solutions" not in self._file or "mesh" not in self._file:
            self.close()
            raise InputError(f"{self.path}: this is no result file of `livermark run`, it has no solutions; "
                             "read it with h5py as results/schema.md says")

    @property
    def is_open(self) -> bool:
        return bool(self._file)

    def close(self) -> None:
        self._file.close()

    def __enter__(self) -> ResultFile:
        return self

    def __exit__(self, *_) -> None:
        self.close()

    @property
    def provenance(self) -> dict[str, Any]:
        """software_version, git_commit, created, command, cpu and the rest"""
        return _attributes(self._file)

    @property
    def body(self) -> str:
        return self.provenance["body"]

    @property
    def load_case(self) -> str:
        return _attributes(self._file["load_case"])["name"]

    @property
    def load_case_attributes(self) -> dict[str, Any]:
        """name, title, definition, load_scale and the rest"""
        return _attributes(self._file["load_case"])

    @property
    def has_motion(self) -> bool:
        """Whether the load case goes on after its static start."""
        return "release" in self._file["load_case"]

    @property
    def path_of_loads(self) -> Optional[NDArray[np.float64]]:
        """(L) parts of the loads at which solutions are kept; None in the small regime"""
        return self._file["load_case/path"][:] if "path" in self._file["load_case"] else None

    @property
    def materials(self) -> dict[str, NDArray[np.float64]]:
        """(R) density [kg/m^3], young_modulus [Pa] and poisson_ratio of each region"""
        return {name: values[:] for name, values in self._file["materials"].items()}

    @property
    def modulus_factor(self) -> Optional[NDArray[np.float64]]:
        """(M) moduli of a tetrahedron over those of its region; None without a map of stiffness"""
        return self._file["mesh/modulus_factor"][:] if "modulus_factor" in self._file["mesh"] else None

    @property
    def assumptions(self) -> list[str]:
        """What the files of the body do not say and was assumed."""
        return _attributes(self._file["mesh"]).get("assumptions", [])

    @property
    def patch_confidence(self) -> Optional[float]:
        """How clear the orientation of a liver is, from 0 to 1; None where patches were not found by its shape."""
        confidence = _attributes(self._file["mesh/boundary_patch"]).get("confidence") if "boundary_patch" in self._file["mesh"] else None
        return None if confidence is None else float(confidence)

    @property
    def boundary_triangles(self) -> NDArray[np.int64]:
        """(T, 3) node numbers, right-handed seen from outside"""
        return self._file["mesh/boundary_triangles"][:]

    @property
    def points(self) -> NDArray[np.float64]:
        """(N, 3) [m]"""
        return self._file["mesh/points"][:]

    @property
    def tetrahedra(self) -> NDArray[np.int64]:
        """(M, 4) node numbers"""
        return self._file["mesh/tetrahedra"][:]

    @property
    def region(self) -> NDArray[np.int32]:
        """(M) index into region_names"""
        return self._file["mesh/region"][:]

    @property
    def region_names(self) -> list[str]:
        return _value(self._file["mesh/region"].attrs["names"])

    @property
    def constraint_names(self) -> list[str]:
        """(P) the places where displacement is prescribed"""
        return _value(self._file["load_case/constraint"].attrs["names"])

    @property
    def tools(self) -> Optional[dict[str, Any]]:
        """What the load case presses, pulls or moves: places, their names (G); drive (G), 0 by a given traction, 1 to a
        depth, 2 to a displacement; middle (G, 3), radius (G) and edge_length (G) [m]; radius_in_edges, the smallest ratio
        of these. None without one, and of older files."""
        group = self._file["load_case"].get("tool")
        if group is None:
            return None
        return {"places": _value(group["drive"].attrs["places"]), **_attributes(group),
                **{name: values[:] for name, values in group.items()}}

    @property
    def capsule(self) -> Optional[dict[str, float]]:
        """thickness [m] and young_modulus [Pa] of the membrane on the surface; None of a body without one"""
        return _attributes(self._file["capsule"]) if "capsule" in self._file else None

    @property
    def vessels(self) -> Optional[dict[str, Any]]:
        """Lines: points (V, 3) [m] and radius (V) [m], segments (W, 2) of two points each, wall_ratio and wall_modulus [Pa]; None of a
        body without them"""
        group = self._file.get("vessels")
        return None if group is None else {**_attributes(group), **{name: values[:] for name, values in group.items()}}

    @property
    def foundation(self) -> Optional[dict[str, NDArray]]:
        """facet (I) of boundary_triangles, stiffness (I) below each [N/m^3] and normal_only (I); None without elastic springs there"""
        group = self._file.get("load_case/foundation")
        return None if group is None else {name: values[:] for name, values in group.items()}

    @property
    def models(self) -> list[str]:
        """Names of the models, as they were run."""
        return list(self._file["solutions"])

    def __getitem__(self, model: str) -> ModelResult:
        if model not in self._file["solutions"]:
            raise InputError(f"{self.path}: there is no model '{model}'; it has {', '.join(self.models)}")
        return ModelResult(self._file, model)

    @property
    def reference(self) -> Optional[dict[str, Any]]:
        """model, reference_uncertainty and the rest; None where that was not found"""
        return _attributes(self._file["reference"]) if "reference" in self._file else None

    @property
    def compared_with(self) -> str:
        """Name of the reference, the model that the displacements of the others are compared with; empty if none is."""
        comparisons = self._file.get("comparisons", {})
        return next((_attributes(group)["reference"] for group in comparisons.values()), "")

    @property
    def reference_on_mesh(self) -> bool:
        """Whether that was solved on the mesh of the models itself: errors differ from those against a refined one."""
        known = self.reference or {}
        name = self.compared_with
        return name != "" and not known.get("model") == known.get("refined_model") == name

    def errors(self) -> pandas.DataFrame:
        """A row for each model: status, degrees_of_freedom, setup_seconds, solve_seconds, and what its comparison has.

        Of the reference, and of a model that was not compared, these are empty.
        """
        wanted = ("status", "degrees_of_freedom", "setup_seconds", "solve_seconds")
        rows = {}
        for name in self.models:
            model = self[name]
            rows[name] = {key: model.attributes[key] for key in wanted} | (model.comparison or {})
        table = _library("pandas", "python3-pandas").DataFrame.from_dict(rows, orient="index")
        table.index.name = "model"
        return table

    def modes(self, model: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Angular frequencies (C) [rad/s] and shapes (C, N, 3) [kg^-1/2], of a file of `livermark modes`."""
        if f"modes/{model}" not in self._file:
            raise InputError(f"{self.path}: there are no modes of '{model}'; make them with `livermark modes`")
        group = self._file["modes"][model]
        return group["angular_frequency"][:], group["shape"][:]

    def to_vtk(self):
        """A vtkUnstructuredGrid: region of the tetrahedra, displacement_<model> and error_<model> [m] of the nodes, and with a
        foundation the largest stiffness of the facets of each."""
        from livermark.convert.pictures import grid_of_result
        return grid_of_result(self)

    def to_pyvista(self):
        """The same as a pyvista.UnstructuredGrid."""
        from livermark.convert.pictures import to_pyvista
        return to_pyvista(self)

    def __repr__(self) -> str:
        return f"<livermark.results.ResultFile {self.load_case} on {self.body}: {len(self.models)} models>"


def open(path: Union[str, os.PathLike[str]]) -> ResultFile:  # noqa: A001 -- livermark.open()
    """Opens a result file of `livermark run`. Raises InputError if it is none."""
    return ResultFile(path)
