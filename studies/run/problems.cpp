#include "studies/run/problems.hpp"

#include <algorithm>
#include <charconv>
#include <fmt/format.h>
#include <iterator>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <utility>

#include "core/mesh/plausible_liver.hpp"
#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/support/processes/mpi_session.hpp"
#include "core/support/toml_input.hpp"
#include "load_cases/places/selector.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "meshes/cutting/cut_reader.hpp"
#include "studies/models/model_table.hpp"
#include "studies/run/run.hpp"
#include "studies/run/solutions.hpp"
#include "studies/study.hpp"

namespace livermark::studies {

namespace {

/// Whether a load case file is none of those that ship.
bool is_own_file(const std::filesystem::path &file) {
    const auto folder = file.parent_path();
    return folder != support::root_folder() / load_cases_folder &&
           folder != support::root_folder() / slow_load_cases_folder;
}

/// Files of load cases: those that ship where none was asked for; those in which time passes in the material only by
/// their names.
std::vector<std::filesystem::path> load_case_files_of(std::vector<std::string> wanted) {
    const auto slow_folder = support::root_folder() / slow_load_cases_folder;
    const auto slow =
        std::filesystem::exists(slow_folder) ? support::list_toml(slow_folder) : std::vector<std::string>{};
    for (auto &name : wanted)
        if (std::ranges::find(slow, name) != slow.end())
            name = (slow_folder / fmt::format("{}.toml", name)).string();
    return find_toml_files(wanted, load_cases_folder, "load case");
}

/// The body that a load case is put on: cut, where it says so.
/// @throws load_cases::NotOnBody if a cut does not fit the body
std::shared_ptr<const core::Body> body_for(const std::filesystem::path &load_case_file,
                                           const std::shared_ptr<const core::Body> &body,
                                           std::vector<std::string> &notes) {
    const auto cuts = meshes::cuts_of_file(load_case_file);
    if (cuts.empty())
        return body;
    try {
        const auto num_known = body->assumptions.size();
        auto cut = std::make_shared<const core::Body>(meshes::cut(*body, cuts));
        for (auto note = num_known; note < cut->assumptions.size(); ++note)
            notes.push_back(
                fmt::format("{}: {}: {}", body->name, load_case_file.stem().string(), cut->assumptions[note]));
        return cut;
    } catch (const meshes::CutNotOnBody &error) {
        throw load_cases::NotOnBody(error.place(), error.reason(), error.remedy());
    }
}

/// Load cases that are read where several fit a body.
enum class Choice { all, first };

/// Leaves the first load case that fits a body, and says why it is none before it.
/// @param first_left_out  of this body, in set.left_out
void keep_first(ProblemSet &set, std::size_t first_left_out) {
    if (first_left_out == set.left_out.size())
        return;
    const auto &before = set.left_out[first_left_out];
    set.notes.push_back(fmt::format("{}: constrained as in {}, because {} does not fit: {}", before.body,
                                    set.problems.back().load_case.name, before.load_case, before.reason));
    set.left_out.resize(first_left_out, before);
}

ProblemSet read_all(const std::vector<std::string> &bodies, const std::vector<std::string> &load_cases,
                    const meshes::MaterialOverride &material, bool may_leave_out, Choice choice = Choice::all) {
    ProblemSet set;
    std::optional<std::string> fault;
    std::map<std::string, std::filesystem::path> file_of_name;
    const auto load_case_files = load_case_files_of(load_cases);
    for (const auto &body_file : find_toml_files(bodies, bodies_folder, "body")) {
        const auto body = std::make_shared<const core::Body>(meshes::read_body(body_file, material));
        const auto [named, is_new] = file_of_name.emplace(body->name, body_file);
        if (!is_new)
            throw support::InputError(
                fmt::format("{} and {} have the same name, and their results would be in one place; rename one",
                            named->second.string(), body_file.string()));
        for (const auto &assumption : body->assumptions)
            set.notes.push_back(fmt::format("{}: {}", body->name, assumption));
        const auto first_left_out = set.left_out.size();
        for (const auto &load_case_file : load_case_files) {
            try {
                const auto cut = body_for(load_case_file, body, set.notes);
                set.problems.push_back({cut, load_cases::read_load_case(load_case_file, *cut)});
                for (const auto &doubt : core::doubts_about_loads(set.problems.back().load_case, cut->mesh))
                    set.notes.push_back(fmt::format("{}: {}", body->name, doubt));
                if (choice == Choice::first) {
                    keep_first(set, first_left_out);
                    break;
                }
            } catch (const load_cases::NotOnBody &error) {
                if (!may_leave_out && !bodies.empty() && is_own_file(load_case_file))
                    throw;
                set.left_out.push_back({body->name, load_case_file.stem().string(), error.reason(),
                                        load_cases::load_case_kind(load_case_file)});
                fault = fault.value_or(error.what());
            }
        }
    }
    if (set.problems.empty())
        throw support::InputError(fault.value());
    return set;
}

void scale_and_note(ProblemSet &set) {
    for (auto &problem : set.problems)
        problem = scaled_to_target(std::move(problem));
    std::ranges::move(yielded_places(set.problems), std::back_inserter(set.notes));
    std::ranges::move(sentences(set.left_out), std::back_inserter(set.notes));
}

std::vector<std::string> usual_constraints_first() {
    std::vector<std::string> names{usual_constraints};
    for (const auto &file : find_toml_files({}, load_cases_folder, "load case"))
        if (const auto name = file.stem().string(); name != usual_constraints)
            names.push_back(name);
    return names;
}

/// Six, so that machines whose arithmetic differs in the last digits of the baseline have the same load, and find
/// references that another one has stored.
double with_few_digits(double factor) {
    const auto digits = fmt::format("{:.5e}", factor);
    std::from_chars(digits.data(), digits.data() + digits.size(), factor);
    return factor;
}

std::vector<CaseGroup> with_the_same_solution(std::span<const core::Problem> problems) {
    std::vector<CaseGroup> case_groups;
    for (std::size_t p = 0; p < problems.size(); ++p) {
        const auto &problem = problems[p];
        const auto same = std::ranges::find_if(case_groups, [&](const CaseGroup &case_group) {
            const auto &first = problems[case_group.front()];
            return first.body == problem.body && core::are_statically_equal(first.load_case, problem.load_case);
        });
        if (same != case_groups.end())
            same->push_back(p);
        else
            case_groups.push_back({p});
    }
    return case_groups;
}

} // namespace

std::vector<std::string> yielded_places(std::span<const core::Problem> problems) {
    std::vector<std::string> lines;
    for (const auto &problem : problems)
        for (const auto &place : problem.load_case.yielded) {
            auto line = fmt::format("{}: {}: '{}' gives up {:.0f} % of its area to the places above it",
                                    problem.body->name, problem.load_case.name, place.name, 100.0 * place.lost_area);
            if (std::ranges::find(lines, line) == lines.end()) // the same for every Poisson's ratio
                lines.push_back(std::move(line));
        }
    return lines;
}

std::vector<LeftOut> grouped(const std::vector<LeftOut> &left_out) {
    std::vector<LeftOut> groups;
    for (const auto &entry : left_out) {
        const auto same = std::ranges::find_if(
            groups, [&](const LeftOut &group) { return group.body == entry.body && group.reason == entry.reason; });
        if (same == groups.end())
            groups.push_back(entry);
        else
            same->load_case += ", " + entry.load_case;
    }
    return groups;
}

std::vector<std::string> sentences(const std::vector<LeftOut> &left_out) {
    std::vector<std::string> lines;
    for (const auto &group : grouped(left_out))
        lines.push_back(fmt::format("left out on {}: {}, because {}", group.body, group.load_case, group.reason));
    return lines;
}

ProblemSet read_problems(const std::vector<std::string> &bodies, const std::vector<std::string> &load_cases,
                         const meshes::MaterialOverride &material, bool may_leave_out) {
    for (const auto &file : load_case_files_of(load_cases)) {
        const auto kind = load_cases::load_case_kind(file);
        if (!kind.is_for(load_cases::run_command))
            throw support::InputError(fmt::format("load case {} {}; give it to 'livermark {} --load-case'",
                                                  file.stem().string(), kind.what, kind.commands.front()));
    }
    return read_all(bodies, load_cases, material, may_leave_out);
}

ProblemSet read_moving_problems(const std::vector<std::string> &bodies, const std::string &load_case,
                                const meshes::MaterialOverride &material) {
    if (const auto kind = load_cases::load_case_kind(load_case); !kind.is_for("arena"))
        throw support::InputError(fmt::format("load case {} has no [tool] that moves; give it to 'livermark {} "
                                              "--load-case', or choose one with a [tool]",
                                              std::filesystem::path(load_case).stem().string(), kind.commands.front()));
    return read_all(bodies, {load_case}, material, false);
}

ProblemSet read_needle_problems(const std::vector<std::string> &bodies, const std::string &load_case,
                                const meshes::MaterialOverride &material) {
    if (const auto kind = load_cases::load_case_kind(load_case); !kind.is_for("needle"))
        throw support::InputError(fmt::format("load case {} has no [[needle]]; give it to 'livermark {} --load-case', "
                                              "or choose one with a [[needle]]",
                                              std::filesystem::path(load_case).stem().string(), kind.commands.front()));
    auto set = read_all(bodies, {load_case}, material, true);
    std::ranges::move(sentences(set.left_out), std::back_inserter(set.notes));
    return set;
}

ProblemSet read_scaled_problems(const std::vector<std::string> &bodies, const std::string &load_case,
                                const meshes::MaterialOverride &material) {
    auto set = read_problems(bodies, {load_case}, material);
    scale_and_note(set);
    return set;
}

ProblemSet read_constrained_problems(const std::vector<std::string> &bodies, const std::string &load_case,
                                     const meshes::MaterialOverride &material) {
    if (!load_case.empty() || bodies.empty())
        return read_scaled_problems(bodies, load_case.empty() ? usual_constraints : load_case, material);
    auto set = read_all(bodies, usual_constraints_first(), material, true, Choice::first);
    scale_and_note(set);
    return set;
}

core::Problem scaled_to_target(core::Problem problem, const core::Model &baseline, PreparedModels &prepared) {
    auto &load_case = problem.load_case;
    if (!load_case.scale_to_target)
        return problem;
    load_case.scale_to_target = false;
    auto at_rest = problem;
    at_rest.load_case = core::without_time(std::move(at_rest.load_case)); // only the static solution is wanted
    const auto solution = prepared.solve(baseline, at_rest);
    double peak = 0.0;
    for (const auto &displacement : solution.displacement)
        peak = std::max(peak, displacement.norm());
    if (solution.status != core::SolutionStatus::ok || !(peak > 0.0))
        throw std::runtime_error(fmt::format("cannot be scaled to its target: {} ends with status {} and a peak "
                                             "displacement of {} m",
                                             baseline.name, core::to_string(solution.status), peak));
    load_case = core::scaled(std::move(load_case), with_few_digits(load_case.target_peak_displacement / peak));
    return problem;
}

core::Problem scaled_to_target(core::Problem problem) {
    if (!problem.load_case.scale_to_target)
        return problem;
    if (support::mpi_num_ranks() > 1)
        throw support::InputError(fmt::format("load case {} is scaled to its target, which this command cannot do on "
                                              "several ranks; start without mpirun",
                                              problem.load_case.name));
    PreparedModels prepared;
    return scaled_to_target(std::move(problem), baseline_of(models::all_models()), prepared);
}

std::vector<core::Problem> at_amplitudes(const core::Problem &problem, std::span<const double> amplitudes) {
    if (amplitudes.empty())
        return {problem};
    std::vector<core::Problem> problems;
    for (const double amplitude : amplitudes) {
        problems.push_back({problem.body, core::scaled(problem.load_case, amplitude)});
        problems.back().load_case.name += fmt::format("@{:g}", amplitude);
    }
    return problems;
}

std::vector<CaseGroup> case_groups_of(std::span<const core::Problem> problems) {
    const auto all = with_the_same_solution(problems);
    const auto first_alike = [&](std::size_t case_group) {
        const auto &problem = problems[all[case_group].front()];
        return std::ranges::find_if(all, [&](const CaseGroup &candidate) {
            const auto &other = problems[candidate.front()];
            return other.body == problem.body && core::constrain_the_same(other.load_case, problem.load_case);
        });
    };
    std::vector<std::size_t> order(all.size());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, {}, first_alike);
    std::ranges::stable_sort(order, std::ranges::greater(), [&](std::size_t case_group) {
        return problems[all[case_group].front()].body->mesh.tetrahedra.size();
    });
    std::vector<CaseGroup> ordered;
    for (const auto case_group : order)
        ordered.push_back(all[case_group]);
    return ordered;
}

std::vector<core::Problem> most_shared(std::span<const core::Problem> problems) {
    struct Candidate {
        const core::Problem *problem;
        std::ptrdiff_t num_sharing; ///< problems that constrain as much or more
    };
    std::vector<Candidate> best; // of each body
    for (const auto &problem : problems) {
        const auto is_of_body = [&](const auto &other) { return other.body == problem.body; };
        const auto constrains_as_much = [&](const auto &other) {
            return is_of_body(other) && core::constrains_all_of(other.load_case, problem.load_case);
        };
        const bool gains = std::ranges::any_of(problems, [&](const auto &other) {
            return constrains_as_much(other) && !core::constrain_the_same(other.load_case, problem.load_case);
        });
        if (!gains)
            continue;
        const Candidate candidate{&problem, std::ranges::count_if(problems, constrains_as_much)};
        const auto known = std::ranges::find_if(best, [&](const auto &other) { return is_of_body(*other.problem); });
        if (known == best.end())
            best.push_back(candidate);
        else if (candidate.num_sharing > known->num_sharing)
            *known = candidate;
    }
    std::vector<core::Problem> shared;
    for (const auto &candidate : best)
        shared.push_back(*candidate.problem);
    return shared;
}

} // namespace livermark::studies
