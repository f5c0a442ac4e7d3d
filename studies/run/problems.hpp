#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "core/problem.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "meshes/io/body_reader.hpp"

namespace livermark::core {
struct Model;
}

namespace livermark::studies {

class PreparedModels;

/// A load case that does not fit a body.
struct LeftOut {
    std::string body, load_case;
    std::string reason; ///< a clause
    load_cases::LoadCaseKind kind;
};

/// Problems that were read, and what their user should know of them.
struct ProblemSet {
    std::vector<core::Problem> problems;
    std::vector<std::string> notes; ///< a sentence each: what had to be assumed
    std::vector<LeftOut> left_out;
};

/// Load cases that do not fit a body for the same reason, as one entry with their names in load_case.
std::vector<LeftOut> grouped(const std::vector<LeftOut> &left_out);

/// A sentence for each place that lost a part of its area, see core::LoadCase::yielded.
std::vector<std::string> yielded_places(std::span<const core::Problem> problems);

/// A sentence for each group.
std::vector<std::string> sentences(const std::vector<LeftOut> &left_out);

/// Reads every body once and puts every load case on it, so that a fault shows before the first hour of work.
///
/// A load case that does not fit a body (see load_cases::NotOnBody) is left out there, and the others are read. It is
/// refused where it is a file of the user's own and the body was asked for by name, unless it may be left out as well.
/// @param bodies      names or paths of what was asked for; all that ship if there are none
/// @param load_cases  the same
/// @return body by body, loads as they are written
/// @throws support::InputError for a fault of any file, if no load case fits any body, and for a moving tool
ProblemSet read_problems(const std::vector<std::string> &bodies, const std::vector<std::string> &load_cases,
                         const meshes::MaterialOverride &material, bool may_leave_out = false);

/// The same of one load case in which a tool moves, which read_problems() refuses.
/// @param load_case  path
ProblemSet read_moving_problems(const std::vector<std::string> &bodies, const std::string &load_case,
                                const meshes::MaterialOverride &material);

/// The same of one load case with a needle, which read_problems() refuses.
/// @param load_case  path
ProblemSet read_needle_problems(const std::vector<std::string> &bodies, const std::string &load_case,
                                const meshes::MaterialOverride &material);

/// The same for a command of one rank and one load case, with the loads scaled to their target where it asks for that.
/// Places that yielded and what is left out are in the notes.
ProblemSet read_scaled_problems(const std::vector<std::string> &bodies, const std::string &load_case,
                                const meshes::MaterialOverride &material);

/// The load case that gives the constraints where none is named.
inline constexpr const char *usual_constraints = "traction";

/// The same for a command that takes constraints from a load case. Where none is named, a body that was asked for by
/// name has those of usual_constraints, or where that does not fit, of the first load case that ships and fits; the
/// notes say which.
/// @param load_case  name or path; empty where none is named
ProblemSet read_constrained_problems(const std::vector<std::string> &bodies, const std::string &load_case,
                                     const meshes::MaterialOverride &material);

/// Multiplies what drives a problem until the linear baseline reaches the target of its load case, where that asks for
/// it (LoadCase::scale_to_target), within 5e-6; the factor, of six digits, goes into LoadCase::load_scale.
/// @param baseline  linear; if it is collective all MPI ranks have to call this
/// @param prepared  what the baseline solves with
/// @return with scale_to_target off, so that nobody scales twice
/// @throws std::runtime_error if the baseline finds no solution, or one that does not move
core::Problem scaled_to_target(core::Problem problem, const core::Model &baseline, PreparedModels &prepared);

/// The same by the baseline of the model table, for commands of one rank.
/// @throws support::InputError on several MPI ranks, where the baseline would wait for the others
core::Problem scaled_to_target(core::Problem problem);

/// The problem at multiples of its load, as load cases "<name>@<amplitude>"; just itself if there are no amplitudes.
/// @param amplitudes  > 0
std::vector<core::Problem> at_amplitudes(const core::Problem &problem, std::span<const double> amplitudes);

/// Numbers of problems of one body with the same static solution, which models keep: one worker takes them one after
/// the other, so that what is kept does not depend on how many workers there are.
using CaseGroup = std::vector<std::size_t>;

/// Groups of all problems. Those that constrain the same components of a body come one after the other: models keep the
/// last factor. Bodies come by their number of tetrahedra, the largest first: it would keep the others waiting at the
/// end. What comes first otherwise stays first.
std::vector<CaseGroup> case_groups_of(std::span<const core::Problem> problems);

/// Problems whose factor others share: of each body with load cases that constrain all that another one constrains and
/// more, the first problem whose constrained components are constrained in most of them.
std::vector<core::Problem> most_shared(std::span<const core::Problem> problems);

} // namespace livermark::studies
