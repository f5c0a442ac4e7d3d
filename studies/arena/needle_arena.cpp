#include "studies/arena/needle_arena.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <optional>
#include <utility>

#include "core/tool/needle/needle_line.hpp"
#include "models/motion/moving_method.hpp"
#include "results/one_reference.hpp"
#include "results/provenance.hpp"
#include "results/records/needle.hpp"
#include "studies/arena/arena_problems.hpp"
#include "studies/arena/needle_run.hpp"
#include "studies/files.hpp"
#include "studies/needle/insertion.hpp"
#include "studies/needle/needle_problems.hpp"
#include "support/input_error.hpp"

namespace livermark::studies {

namespace {

constexpr const char *needle_obstacle =
    "the masses of its stiff parts are scaled, and impulses of a needle are those of true masses";

/// Methods that move, and why others do not.
struct ChosenMethods {
    std::vector<models::MovingMethod> methods;
    std::vector<results::LeftOut> left_out;
};

ChosenMethods chosen_methods_with_needle(const std::vector<std::string> &names) {
    ChosenMethods chosen;
    auto all = models::all_moving_methods();
    for (const auto &name : names)
        support::find_named(all, name, "method");
    for (auto &method : all) {
        const bool is_asked_for = std::ranges::find(names, method.name) != names.end();
        if (names.empty() ? method.only_when_named : !is_asked_for)
            continue;
        if (!method.is_scaled)
            chosen.methods.push_back(std::move(method));
        else if (is_asked_for)
            throw support::InputError(
                fmt::format("{} holds no needle, because {}; leave it out", method.name, needle_obstacle));
        else
            chosen.left_out.push_back({method.name, needle_obstacle});
    }
    return chosen;
}

std::vector<core::Needle> chosen_needles(const NeedleProblem &problem, const std::vector<std::string> &names) {
    if (names.empty())
        return problem.needles;
    std::vector<core::Needle> chosen;
    for (const auto &name : names)
        chosen.push_back(support::find_named(problem.needles, name, "needle of the load case"));
    return chosen;
}

/// The tip moves on by half the distance of two places at most in a step, which is a frame in implicit methods.
void refuse_too_fast(const core::Needle &needle, const models::NeedlePlan &plan) {
    constexpr double largest_part = 0.4;
    const double fastest = largest_part * core::needle_line(needle).spacing / plan.frame_interval;
    if (plan.speed > fastest)
        throw support::InputError(fmt::format("'{}' is led at {:.3g} m/s, and forces that are spread over {:.3g} m "
                                              "follow no more than {:.3g} m/s; give a lower --speed",
                                              needle.name, plan.speed, needle.spread, fastest));
}

/// What is known of a needle without methods.
struct ReferenceOfNeedle {
    results::NeedleStudy study; ///< with an arena
    std::vector<core::Vector3> places;
};

ReferenceOfNeedle reference_of_needle(const core::Problem &problem, const core::Needle &needle,
                                      const models::NeedlePlan &plan, const core::Model &model) {
    const auto line = core::needle_line(needle);
    const auto compliance = model.compliance(problem, line.places);
    results::NeedleStudy study{.needle = needle, .runs = {}};
    study.runs.push_back({model.name, insert(compliance.matrix, line, needle), compliance.seconds});
    study.runs.front().note_limit(results::largest_small_displacement(problem));
    const auto &insertion = study.runs.front().insertion;
    std::optional<core::Insertion> coarser;
    if (!compliance.on_coarser.empty()) {
        coarser = insert(compliance.on_coarser.back(), line, needle);
        study.reference_miss_change = (insertion.target[insertion.at_plan] - coarser->target[coarser->at_plan]).norm();
        study.reference_force_change = results::force_error(*coarser, insertion);
    }
    study.arena = empty_needle_arena(needle, plan, insertion, coarser ? &*coarser : nullptr);
    auto places = insertion.places;
    return {std::move(study), std::move(places)};
}

} // namespace

NeedleArenaResults run_needle_arena(const ArenaOptions &options, const NeedleArenaOptions &needle_options,
                                    const std::string &command_line, const ProgressReport &report) {
    const auto [methods, left_out] = chosen_methods_with_needle(options.methods);
    const auto reference = needle_reference_model(needle_options.reference_on_mesh);
    const models::NeedlePlan plan{.speed = needle_options.speed, .rest = needle_options.rest};
    NeedleArenaResults done;
    const auto problems = read_with_needles({.bodies = options.bodies,
                                             .load_case = options.load_case,
                                             .models = {},
                                             .material = options.material,
                                             .output = {}},
                                            done.notes);
    std::size_t num_needles = 0;
    for (const auto &problem : problems) {
        refuse_single_components(problem.problem.load_case);
        for (const auto &needle : chosen_needles(problem, needle_options.needles)) {
            refuse_too_fast(needle, plan);
            ++num_needles;
        }
    }
    Steps steps(static_cast<int>(num_needles * (1 + methods.size() * options.meshes.size())), report);
    for (const auto &with_needles : problems) {
        const auto &problem = with_needles.problem;
        const OutputFile output(options.output, problem, fmt::format("needle_arena.{}.h5", problem.load_case.name));
        results::NeedleFile file{.provenance = results::current_provenance(command_line),
                                 .body = problem.body->name,
                                 .load_case = problem.load_case.name,
                                 .title = problem.load_case.title,
                                 .needles = {}};
        for (const auto &needle : chosen_needles(with_needles, needle_options.needles)) {
            steps.next(fmt::format("{} / {} / {}", problem.body->name, needle.name, reference.name));
            auto [study, places] = reference_of_needle(problem, needle, plan, reference);
            study.arena->left_out = left_out;
            for (const int mesh : options.meshes) {
                const auto on_mesh = on_arena_mesh(problem, mesh);
                const NeedleScene scene{on_mesh, needle, plan, *study.arena, places};
                for (const auto &method : methods) {
                    steps.next(fmt::format("{} / {} / {} tetrahedra / {}", problem.body->name, needle.name,
                                           on_mesh.body->mesh.tetrahedra.size(), method.name));
                    std::ranges::move(run_needle_budgets(method, scene, options.budgets),
                                      std::back_inserter(study.arena->runs));
                }
            }
            file.needles.push_back(std::move(study));
        }
        results::write_needles(output.path(), file);
        done.of_body.push_back(std::move(file));
    }
    return done;
}

} // namespace livermark::studies
