#pragma once

#include <string>
#include <vector>

#include "core/problem.hpp"
#include "meshes/body_reader.hpp"

namespace livermark::studies {

/// Problems that were read, and what their user should know of them.
struct ProblemSet {
    std::vector<core::Problem> problems;
    std::vector<std::string> notes; ///< a sentence each: what had to be assumed, what was passed over
};

/// Reads every body once and puts every load case on it, so that a fault shows before the first hour of work.
///
/// A load case may name a patch or a region that a body does not have. That is refused where both were asked for by
/// name; else the two are passed over, with a note for each body.
/// @param bodies      names or paths of what was asked for; all that ship if there are none
/// @param load_cases  the same
/// @return body by body, loads as they are written
/// @throws support::InputError for a fault of any file, and if no load case fits any body
ProblemSet read_problems(const std::vector<std::string> &bodies, const std::vector<std::string> &load_cases,
                         const meshes::MaterialOverride &material);

/// The same for a command of one rank and one load case, with the loads scaled to their target where it asks for that.
ProblemSet read_scaled_problems(const std::vector<std::string> &bodies, const std::string &load_case,
                                const meshes::MaterialOverride &material);

} // namespace livermark::studies
