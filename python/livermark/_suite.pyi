from typing import Optional,
    Sequence

        import numpy as np from numpy.typing import ArrayLike,
    NDArray

    class Problem : @property def
                    body(self)
                        ->str : ... @property def load_case(self)
                        ->str : ... @property def regime(self)
                        ->str : ... @property def notes(self)
                        ->list[str] : ... @property def points(self)
                        ->NDArray[np.float64] : ... @property def tetrahedra(self)
                        ->NDArray[np.int32] : ... @property def region(self)
                        ->NDArray[np.int32] : ... @property def region_names(self)
                        ->list[str] : ... @property def boundary_triangles(self)
                        ->NDArray[np.int32] : ... @property def young_modulus(self)
                        ->NDArray[np.float64] : ... @property def poisson_ratio(self)
                        ->NDArray[np.float64] : ... @property def density(self)
                        ->NDArray[np.float64] : ... @property def prescribed_displacement(self)
                        ->NDArray[np.float64] : ... @property def fixed(self)
                        ->NDArray[np.bool_] : ... @property def forces(self)
                        ->NDArray[np.float64] : ... @property def press_depth(self)
                        ->float : ... @property def follower_pressure(self)
                        ->NDArray[np.float64] : ... @property def dead_forces(self)
                        ->NDArray[np.float64] : ... @property def constraint_names(self)
                        ->list[str] : ... def solve(self, model
                                                    : str)
                        ->Solution : ... def score(self, displacement
                                                   : ArrayLike, name
                                                   : str = ..., models
                                                   : Sequence[str] = ..., with_uncertainty
                                                   : bool = ..., output
                                                   : Optional[str] = ...)
                        ->Score : ...

                                  class Solution : @property def status(self)
                        ->str : ... @property def message(self)
                        ->str : ... @property def displacement(self)
                        ->NDArray[np.float64] : ... @property def reaction(self)
                        ->NDArray[np.float64] : ... @property def strain_energy(self)
                        ->float : ... @property def degrees_of_freedom(self)
                        ->int : ... @property def setup_seconds(self)
                        ->float : ... @property def solve_seconds(self)
                        ->float : ... @property def solver(self)
                        ->str : ... @property def edges(self)
                        ->Optional[NDArray[np.int32]] : ... @property def stiffness(self)
                        ->Optional[NDArray[np.float64]] : ... @property def rest_length(self)
                        ->Optional[NDArray[np.float64]] : ... @property def node_mass(self)
                        ->Optional[NDArray[np.float64]] : ... @property def time(self)
                        ->Optional[NDArray[np.float64]] : ... @property def probe_displacement(self)
                        ->Optional[NDArray[np.float64]] : ... @property def kinetic_energy_history(self)
                        ->Optional[NDArray[np.float64]] : ... @property def strain_energy_history(self)
                        ->Optional[NDArray[np.float64]] : ...

                                                          class Score : @property def name(self)
                        ->str : ... @property def reference(self)
                        ->str : ... @property def relative_l2(self)
                        ->float : ... @property def max_error(self)
                        ->float : ... @property def max_error_relative(self)
                        ->float : ... @property def uncertainty(self)
                        ->Optional[float] : ... @property def within_uncertainty(self)
                        ->bool : ... @property def error(self)
                        ->NDArray[np.float64] : ... @property def relative_l2_of_models(self)
                        ->dict[str, float] : ...

                                             def bodies()
                        ->list[str] : ... def load_cases()
                        ->list[str] : ... def models()
                        ->list[str] : ... def problem(body
                                                      : str, load_case
                                                      : str, young_modulus
                                                      : Optional[float] = ..., poisson_ratio
                                                      : Optional[float] = ...)
                        ->Problem : ...
