"""Livermark: springs for soft tissue, their motion, and a benchmark suite that judges them.

Arrays come in and go out as numpy arrays, all quantities are in SI units. See docs/reference/python.md.
"""
from typing import TYPE_CHECKING as _TYPE_CHECKING

try:
    import numpy as _numpy  # noqa: F401 -- all functions take its arrays
except ModuleNotFoundError as _error:
    import sys as _sys
    raise ModuleNotFoundError(f"livermark needs {_error.name}, which {_sys.executable} does not have; start /usr/bin/python3 with "
                              "Debian's python3-numpy, or install numpy there", name=_error.name) from _error

from livermark import suite as _suite_functions
from livermark._version import __version__
from livermark.calibration import calibrate
from livermark.convert import Mesh, from_meshio, to_sofa
from livermark.convert.febio import GroundSprings, Solid, from_febio, to_febio
from livermark.convert.pictures import to_pyvista, to_slicer, to_vtk, vessels_to_vtk
from livermark.convert.tool_scene import ToolScene, read_tool_scene, tool_scene_to_febio, tool_scene_to_sofa
from livermark.errors import DivergedError, InputError
from livermark.results import open
from livermark.suite import advise, bodies, cut, load_cases, models, problem, score, solve

if _TYPE_CHECKING:
    from livermark._suite import CutBody, Problem, Score, Solution

__all__ = [
    "CutBody", "DivergedError", "GroundSprings", "InputError", "Mesh", "Problem", "RayleighDamping", "Score", "Simulation", "Solid", "Solution", "Springs",
    "ToolScene", "advise", "bodies", "calibrate", "coupled_spring_models", "coupled_springs", "critical_time_step", "cut", "engine_parameters", "engines", "from_febio", "from_meshio", "integrators",
    "largest_angular_frequency", "load_cases", "mass_proportional_damping", "models", "open", "problem",
    "rayleigh_damping", "read_tool_scene", "score", "solve", "spring_laws", "springs",
    "stiffness_proportional_damping", "to_febio", "to_pyvista", "to_slicer", "to_sofa", "to_vtk",
    "tool_scene_to_febio", "tool_scene_to_sofa", "two_mode_damping", "vessels_to_vtk", "volume_terms"]
try:
    from livermark._livermark import (RayleighDamping, Simulation, Springs, coupled_spring_models, coupled_springs, critical_time_step,
                                      engine_parameters, engines, integrators, largest_angular_frequency, mass_proportional_damping,
                                      rayleigh_damping, spring_laws, springs,
                                      stiffness_proportional_damping, two_mode_damping, volume_terms)
except ModuleNotFoundError as _error:  # result files are read without compiled code
    if _error.name != "livermark._livermark":
        raise


def __getattr__(name):
    if name in ("CutBody", "Problem", "Score", "Solution"):  # they come with finite elements, which load when they are asked for
        return getattr(_suite_functions.load(), name)
    if name in __all__:
        raise ImportError(f"livermark.{name} is compiled, and {_suite_functions.lack_of('_livermark')}")
    raise AttributeError(f"module 'livermark' has no attribute '{name}'")
