#include "studies/models/pushed_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/mesh/refinement.hpp"
#include "core/support/processes/mpi_session.hpp"
#include "fem_reference/hyperelastic/hyperelasticity.hpp"
#include "fem_reference/hyperelastic/slow_path.hpp"
#include "fem_reference/linear/linear_elasticity.hpp"
#include "msm/statics/rest_stiffness.hpp"
#include "studies/models/mass_spring_model.hpp"
#include "studies/models/model_table.hpp"
#include "studies/models/refined_solution.hpp"

namespace livermark::models::families {

namespace {

using hyperelastic::Discretisation;

/// Forces out of balance over reactions and loads. The discretisation is wrong by a thousandth at best.
constexpr double tolerance = 1e-8;

/// (T) [Pa]; empty if no pressure follows the surface
std::vector<double> follower_pressures(const core::Problem &problem) {
    std::vector<double> pressure;
    const auto &mesh = problem.body->mesh;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (problem.load_case.follows_surface(f)) {
            pressure.resize(mesh.boundary_triangles.size());
            pressure[f] = core::follower_pressure(problem.load_case, mesh, f);
        }
    return pressure;
}

/// Several MPI ranks solve together what a factor is not needed for. What a ball touches each of them solves alone.
bool is_collective(const Discretisation &discretisation) {
    return support::mpi_num_ranks() > 1 && discretisation.formulation == fem_reference::Formulation::mixed;
}

core::Solution solve(const core::Problem &problem, const std::string &law, const Discretisation &discretisation) {
    hyperelastic::LoadPath path;
    path.fractions = problem.load_case.path;
    path.tolerance = tolerance;
    if (path.fractions.empty())
        path.fractions = {1.0};
    const core::Problem dead{problem.body, core::without_follower_pressures(problem.load_case)};
    const auto &material = hyperelastic::material_law(law);
    if (problem.load_case.slow_history)
        return hyperelastic::solve_history(dead, material, discretisation, tolerance, follower_pressures(problem));
    auto found = is_collective(discretisation) && !problem.load_case.contact()
                     ? hyperelastic::solve_distributed(dead, material, path, follower_pressures(problem))
                     : hyperelastic::solve(dead, material, discretisation, path, follower_pressures(problem));
    auto solution = std::move(found.solution);
    for (const auto &point : found.points) {
        if (solution.path.size() == problem.load_case.path.size() ||
            point.fraction != problem.load_case.path[solution.path.size()])
            break; // where it ended early
        auto &kept = solution.path.emplace_back();
        for (const auto &displacement : point.displacement)
            kept.displacement.push_back(displacement.cast<float>());
        kept.reaction = point.reaction;
        kept.strain_energy = point.strain_energy;
    }
    return solution;
}

/// One percent, where four meshes give it.
constexpr Refinement refinement{.goal = 0.01, .finest_level = 3};

/// Distance from the middle of what is touched up to which meshes are refined, over its radius.
constexpr double around_touch = 1.5;

/// At rims and below tools, or below a tool that touches.
core::BisectedProblem refine(const core::Problem &coarse) {
    const auto contact = coarse.load_case.contact();
    if (!contact)
        return core::refine_at_rims_and_tools(coarse);
    const core::InteriorPlace place{contact->middle, contact->radius};
    return core::refine_near_places(coarse, std::span(&place, 1), around_touch);
}

/// Histories on ever finer meshes would take hours: these are solved at their limits alone.
core::Solution solve_finer(const core::Problem &problem, const std::string &law, const Discretisation &discretisation) {
    const auto on_one_mesh = [&](const core::Problem &one) { return solve(one, law, discretisation); };
    const auto on_finer_meshes = [&](const core::Problem &elastic) {
        return solve_locally_refined(elastic, refinement, refine, on_one_mesh);
    };
    return problem.load_case.slow_history ? solve_between_limits(problem, on_one_mesh, on_finer_meshes)
                                          : on_finer_meshes(problem);
}

using Solve = core::Solution (*)(const core::Problem &, const std::string &, const Discretisation &);

/// Roles of a model at rest and in motion.
struct Roles {
    core::Role at_rest = core::Role::candidate;
    core::Role in_motion = core::Role::candidate;
};

constexpr Discretisation linear_elements{.degree = 1}, quadratic_elements{.degree = 2},
    mixed_elements{.degree = 2, .formulation = fem_reference::Formulation::mixed};

constexpr std::array<HyperelasticElements, 5> all_elements{
    {{.name = "fem_p1_neo_hookean", .law = "neo_hookean", .discretisation = linear_elements},
     {.name = "fem_p2_neo_hookean", .law = "neo_hookean", .discretisation = quadratic_elements},
     {.name = "fem_p2p1_neo_hookean", .law = "neo_hookean", .discretisation = mixed_elements},
     {.name = "fem_p2p1_neo_hookean_refined",
      .law = "neo_hookean",
      .discretisation = mixed_elements,
      .is_refined = true},
     {.name = "fem_p2p1_ogden", .law = "ogden", .discretisation = mixed_elements}}};

core::Model elements(const std::string &name, const std::string &summary, const Roles &roles = {},
                     Solve solve_one = solve) {
    const auto made_of = *hyperelastic_elements(name);
    const std::string law(made_of.law);
    const auto discretisation = made_of.discretisation;
    return {.name = name,
            .summary = summary,
            .source = "Arndt et al. 2022, The deal.II library, version 9.4, J. Numer. Math. 30(3)",
            .prepare = core::solves_each(
                [=](const core::Problem &problem) { return solve_one(problem, law, discretisation); }),
            .at_rest = roles.at_rest,
            .in_motion = roles.in_motion,
            .judges = core::Regime::large,
            .only = core::Regime::large,
            .follows = core::EventSet::all(),
            .is_collective = is_collective(discretisation)};
}

std::vector<core::Model> models(const ModelOptions & /*options*/) {
    return {
        elements("fem_p1_neo_hookean", "neo-Hookean, linear tetrahedra (the baseline of large deformations)"),
        elements("fem_p2_neo_hookean", "neo-Hookean, quadratic tetrahedra", {.in_motion = core::Role::reference}),
        elements("fem_p2p1_neo_hookean", "neo-Hookean, quadratic tetrahedra with a linear pressure (Taylor and Hood)",
                 {.at_rest = core::Role::reference}),
        elements("fem_p2p1_neo_hookean_refined",
                 "neo-Hookean, Taylor and Hood on meshes refined at the rims of places and below round tools (the "
                 "reference of large deformations)",
                 {.at_rest = core::Role::refined_reference}, solve_finer),
        elements("fem_p2p1_ogden",
                 "Ogden's law with a fit to porcine liver, Taylor and Hood: how far the law itself matters"),
    };
}

} // namespace

/// Hyperelastic finite elements on the same tetrahedra.
ModelFamily hyperelastic() {
    return {.name = {}, .models = models};
}

} // namespace livermark::models::families

namespace livermark::models {

std::optional<HyperelasticElements> hyperelastic_elements(std::string_view name) {
    const auto found = std::ranges::find(families::all_elements, name, &HyperelasticElements::name);
    return found != families::all_elements.end() ? std::optional(*found) : std::nullopt;
}

namespace {

/// The same as of the linear reference.
constexpr double near_places = 1.5;
constexpr int meshes_near_places = 3;

std::unique_ptr<core::PushedBody> push_elements(const HyperelasticElements &elements, core::Problem problem,
                                                std::span<const core::InteriorPlace> places, int mesh,
                                                const Eigen::MatrixXd *known) {
    const auto &discretisation = elements.discretisation;
    const auto at_rest = [&] {
        return fem_reference::StaticSolver(problem.body, discretisation.degree, fem_reference::SolverChoice::automatic,
                                           discretisation.formulation)
            .compliance(problem.load_case, places)
            .matrix;
    };
    auto compliance = known ? *known : at_rest();
    for (int level = 0; level < mesh; ++level)
        problem = core::refine_near_places(problem, places, near_places).problem;
    return hyperelastic::pushed_elements(problem, hyperelastic::material_law(std::string(elements.law)), discretisation,
                                         places, std::move(compliance));
}

} // namespace

std::optional<PushedModel> pushed_model(const core::Model &model) {
    if (const auto elements = hyperelastic_elements(model.name))
        return PushedModel{.num_meshes = elements->is_refined ? meshes_near_places : 1,
                           .prepare = [elements = *elements](const core::Problem &problem,
                                                             std::span<const core::InteriorPlace> places, int mesh,
                                                             const Eigen::MatrixXd *known) {
                               return push_elements(elements, problem, places, mesh, known);
                           }};
    if (!has_springs(model))
        return std::nullopt;
    return PushedModel{.prepare = [model](const core::Problem &problem, std::span<const core::InteriorPlace> places,
                                          int /*mesh*/, const Eigen::MatrixXd * /*known*/) {
        return msm::pushed_springs(springs_of(model, problem.body)->body, problem, places);
    }};
}

} // namespace livermark::models
