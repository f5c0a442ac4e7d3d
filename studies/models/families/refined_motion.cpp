#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/error_norms.hpp"
#include "core/mesh/refinement.hpp"
#include "core/support/processes/mpi_session.hpp"
#include "fem_reference/hyperelastic/hyperelasticity.hpp"
#include "fem_reference/linear/linear_elasticity.hpp"
#include "studies/models/model_table.hpp"

namespace livermark::models::families {

namespace {

/// Steps between two records, so that the error of steps counts as well.
struct Levels {
    int finest;           ///< how often the mesh is refined at the rims of places
    int steps_per_record; ///< on each mesh
};

/// The same motion in more steps, recorded at each.
core::Problem with_more_steps(core::Problem problem, int steps_per_record) {
    auto &release = problem.load_case.release.value();
    release.num_steps *= steps_per_record;
    release.output_interval /= steps_per_record;
    return problem;
}

/// The records that are wanted, and no frames.
core::History thinned(core::History history, int steps_per_record, const core::Release &wanted) {
    const std::size_t num_probes = wanted.probes.size();
    core::History result = history;
    result.observed_error.reset(); // of the steps
    result.time.clear();
    for (auto *const list : {&result.kinetic_energy, &result.strain_energy})
        list->clear();
    result.displacement.clear();
    result.frames.clear();
    for (int record = 0; record <= wanted.num_steps; ++record) {
        const auto from = static_cast<std::size_t>(record) * static_cast<std::size_t>(steps_per_record);
        result.time.push_back(record * wanted.output_interval);
        result.kinetic_energy.push_back(history.kinetic_energy[from]);
        result.strain_energy.push_back(history.strain_energy[from]);
        for (std::size_t q = 0; q < num_probes; ++q)
            result.displacement.push_back(history.displacement[from * num_probes + q]);
    }
    return result;
}

using Solve = core::Solution (*)(const core::Problem &);

core::Solution solve_linear(const core::Problem &problem) {
    fem_reference::StaticSolver solver(problem.body, 2, fem_reference::SolverChoice::automatic,
                                       fem_reference::Formulation::mixed);
    return solver.solve_with_motion(problem.load_case);
}

core::Solution solve_neo_hookean(const core::Problem &problem) {
    hyperelastic::LoadPath path;
    if (!problem.load_case.path.empty())
        path.fractions = problem.load_case.path;
    return hyperelastic::solve(problem, hyperelastic::material_law("neo_hookean"), {.degree = 2}, path).solution;
}

/// Start and motion on the finest mesh, at the nodes of the mesh, which come first there. On all meshes where there are
/// enough to observe an order.
core::Solution solve_on_levels(const core::Problem &problem, Solve solve, const Levels &levels) {
    std::vector<core::History> histories;
    core::Solution finest;
    double setup_seconds = 0.0, solve_seconds = 0.0;
    for (int level = levels.finest >= 2 ? levels.finest - 2 : levels.finest; level <= levels.finest; ++level) {
        const auto refined = core::refine_at_rims(problem, level);
        finest = solve(refined.load_case.release ? with_more_steps(refined, levels.steps_per_record) : refined);
        finest.displacement.resize(problem.body->mesh.points.size());
        setup_seconds += finest.setup_seconds;
        solve_seconds += finest.solve_seconds;
        if (finest.status != core::SolutionStatus::ok)
            return finest;
        if (finest.history) {
            histories.push_back(
                thinned(*std::move(finest.history), levels.steps_per_record, problem.load_case.release.value()));
            finest.history = histories.back();
        }
    }
    if (histories.size() >= 3)
        finest.history->observed_error = core::observed_motion_error(histories, core::first_order_factor);
    finest.setup_seconds = setup_seconds;
    finest.solve_seconds = solve_seconds;
    return finest;
}

core::Model elements(std::string_view name, const std::string &summary, core::Regime regime, Solve solve,
                     const Levels &levels) {
    return {.name = std::string(name),
            .summary = summary,
            .source = "Arndt et al. 2022, The deal.II library, version 9.4, J. Numer. Math. 30(3)",
            .prepare = core::solves_each(
                [=](const core::Problem &problem) { return solve_on_levels(problem, solve, levels); }),
            .in_motion = core::Role::refined_reference,
            .judges = regime,
            .only = regime,
            .only_moving = true};
}

std::vector<core::Model> models(const ModelOptions & /*options*/) {
    if (support::mpi_num_ranks() > 1)
        return {}; // they solve alone
    using enum core::Regime;
    return {
        elements("fem_p2p1_refined_at_rims",
                 "linear elasticity, Taylor and Hood on the mesh refined twice at the rims of places (tells how good "
                 "the motion of fem_p2 is)",
                 small, solve_linear, {.finest = 2, .steps_per_record = 4}),
        elements("fem_p2_neo_hookean_refined_at_rims",
                 "neo-Hookean, quadratic tetrahedra on the mesh refined once at the rims of places (tells how good the "
                 "motion of fem_p2_neo_hookean is)",
                 large, solve_neo_hookean, {.finest = 1, .steps_per_record = 1}),
    };
}

} // namespace

/// Finite elements that tell how good the motion of others is: on meshes that are finer at the rims of places, in
/// shorter steps.
ModelFamily refined_motion() {
    return {.name = {}, .models = models};
}

} // namespace livermark::models::families
