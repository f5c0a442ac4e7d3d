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
/// model is set up for the body that it leaves, and the median of the equilibrium that follows [ms]. The reference is
/// CutFile::judge_in_the_end(); a refined one has no released energy, and a row of its own with its error bars [%].
Layout cut_models_table(const CutFile &file);

/// A sentence: which reference errors of models and methods are against, and how exact it is.
std::string cut_judge_note(const CutFile &file);

/// A row for each mesh on which the reference was solved in the end: how the body was cut, tetrahedra, area cut [cm^2],
/// mean depth of the rim [mm], opening [mm], stiffness at the tool [N/m], time of the equilibrium with the set-up [s].
Layout cut_levels_table(const CutFile &file);

/// A sentence for each way to cut with three meshes: opening and stiffness on the finest one, with their errors, and
/// how far the reference on the coarsest one is from that. Empty if there is none.
std::string cut_levels_note(const CutFile &file);

/// A row for each model of springs: its critical step before the cut, after it along facets, and after the exact cut
/// [ms]. No rows where no model has springs.
Layout cut_steps_table(const CutFile &file);

/// A row for each method that moves within each budget, in the order of budgets, and of the larger one of the errors of
/// opening and stiffness in one; methods that are too slow for it come last: budget [ms], whether it is kept (always,
/// but for frames with a cut, or never), steps and iterations, opening [mm] and stiffness at the tool [N/m] in the end,
/// both beside the reference [%], the larger one of both, whose it is; the median and the longest time from a cut body
/// to the next frame, the median frame and the longest one with the cut before it [ms]. Of the settings of a method the
/// best in this order is shown.
Layout cut_motions_table(const CutFile &file);

/// A sentence: where the reference releases more than tearing takes.
std::string cut_note(const CutFile &file);

} // namespace livermark::results
