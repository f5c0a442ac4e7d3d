#pragma once

#include "results/records/growing_cut.hpp"
#include "results/tables/table_layout.hpp"

namespace livermark::results {

/// A row for each record of the reference: depth of the blade [mm], area cut [cm^2], opening [mm], what is stored [mJ],
/// what was released so far [mJ], energy released over area cut in the step [J/m^2], and what of tearing the blade has
/// to do itself so far [mJ]: where the rate is above the toughness the cut goes on by itself.
Layout cut_table(const CutFile &file);

/// A row for each model: opening at the end [mm], energy released in all [mJ], over the whole area [J/m^2], both beside
/// the reference [%], and the median time of an equilibrium [ms].
Layout cut_models_table(const CutFile &file);

} // namespace livermark::results
