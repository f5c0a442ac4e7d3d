#pragma once

#include <string>
#include <vector>

#include "core/model.hpp"
#include "core/problem.hpp"
#include "core/tool/needle/needle_line.hpp"
#include "studies/needle/needle_study.hpp"

namespace livermark::studies {

/// A body, and the needles that are driven into it.
struct NeedleProblem {
    core::Problem problem;
    std::vector<core::Needle> needles;
};

/// The reference of a regime, on meshes of its own or on the mesh itself.
core::Model needle_reference_model(bool on_mesh, core::Regime regime = core::Regime::small);

/// The reference first, then those that were asked for, each once.
/// @throws support::InputError for a model that cannot tell
std::vector<core::Model> models_with_needles(const NeedleOptions &options);

/// The load case on the bodies, one or more, in the regime and with the step that was asked for.
/// @param notes  what a user should know of the input, a sentence each
/// @throws support::InputError for bad input
std::vector<NeedleProblem> read_with_needles(const NeedleOptions &options, std::vector<std::string> &notes);

} // namespace livermark::studies
