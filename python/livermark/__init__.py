"""Livermark: springs for soft tissue, their motion, and a benchmark suite that judges them.

Arrays come in and go out as numpy arrays, all quantities are in SI units. See docs/python.md.
"""
from livermark.errors import InputError
from livermark._livermark import (RayleighDamping, Simulation, Springs, coupled_springs, critical_time_step,
                                  integrators, largest_angular_frequency, mass_proportional_damping,
                                  rayleigh_damping, spring_energies, spring_laws, springs,
                                  stiffness_proportional_damping, two_mode_damping, volume_terms)
