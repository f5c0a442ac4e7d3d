#pragma once

#include <string>

#include "results/hdf5/files/stability_file.hpp"
#include "results/tables/table_layout.hpp"

namespace livermark::results {

/// One row per integrator: the longest stable step without and with damping, predicted and observed [ms], and the
/// difference of the observed from the predicted one [%]. "none" where no step is stable, "any" where every one is,
/// "not observed" where nobody looked or nobody could see.
Layout stability_table(const Stability &stability);

/// What to take: "box, nodal_neo_hookean: take 0.72 ms, 0.8 of the longest stable step of symplectic_euler; with this
/// damping 0.31 ms". Of symplectic Euler, or if it is not there, of the first integrator with a longest step; "take any
/// step" where none has one.
/// @param part  of the longest stable step that is predicted
std::string step_advice(const Stability &stability, double part);

} // namespace livermark::results
