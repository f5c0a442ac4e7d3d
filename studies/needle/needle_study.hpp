#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/load_case.hpp"
#include "meshes/io/body_reader.hpp"
#include "results/records/needle.hpp"
#include "studies/progress.hpp"

namespace livermark::studies {

/// What `livermark needle` was asked for.
struct NeedleOptions {
    std::vector<std::string> bodies;  ///< names or paths
    std::string load_case = "biopsy"; ///< of load_cases/needles/, or a path
    std::vector<std::string> models;  ///< all that run by default and can tell if there are none
    core::Regime regime = core::Regime::small;
    std::optional<double> step{};   ///< from record to record, at most [m], > 0; that of the load case, see below
    bool reference_on_mesh = false; ///< judged by the mixed elements on the mesh itself
    meshes::MaterialOverride material;
    std::string output; ///< folder for <body>/needle.<load case>.h5, or .large.h5
};

struct NeedleResults {
    std::vector<results::NeedleFile> of_body;
    std::vector<std::string> notes; ///< what a user should know of the input, a sentence each
};

/// Of the large regime where none is asked for [m]: each record takes several equilibria of the body.
inline constexpr double large_needle_step = 0.002;

/// Drives the needles of a load case into bodies, by each model, and writes a file for each body. All that is the
/// needle's is the same for all models and both regimes, see insert().
///
/// In the small regime what a model says is linear in the forces, and how it gives way along the needle is found once,
/// see core::Compliance. In the large one springs and hyperelastic elements come to rest under the forces themselves
/// (core::PushedBody), and the reference is hyperelastic; linear elements take part as they are, which shows what
/// linearity costs.
/// @throws support::InputError for bad input, for a model that cannot tell, and where a file cannot be written
NeedleResults drive_needles(const NeedleOptions &options, const std::string &command_line,
                            const ProgressReport &report);

} // namespace livermark::studies
