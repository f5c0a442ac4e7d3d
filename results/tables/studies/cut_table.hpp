#pragma once

#include <string>

#include "results/records/growing_cut.hpp"
#include "results/tables/table_layout.hpp"

namespace livermark::results {

/// A row for each record of the reference: depth of the blade [mm], area cut [cm^2], opening [mm], what is stored [mJ],
/// what was released so far [mJ], energy released over area cut in the step [J/m^2], what of tearing the blade has to
/// do itself so far [mJ], stiffness at the tool [N/m], and the time that dividing the body took [ms].
Layout cut_table(const CutFile &file);

/// A row for each model: opening at the end [mm], energy released in all [mJ], over the whole area [J/m^2], stiffness
/// at the tool at the end [N/m], all beside the reference [%]; the median and the longest time from the blade until the
/// model is set up for the body that it leaves, and the median of the equilibrium that follows [ms].
Layout cut_models_table(const CutFile &file);

/// A row for each method that moves within each budget, of the setting whose opening is nearer to the reference in the
/// end: budget [ms], steps and iterations, opening [mm] and stiffness at the tool [N/m] in the end, both beside the
/// reference [%]; the median and the longest time from a cut body to the next frame, the median frame and the longest
/// one with the cut before it [ms].
Layout cut_motions_table(const CutFile &file);

/// A sentence: where the reference releases more than tearing takes.
std::string cut_note(const CutFile &file);

} // namespace livermark::results
