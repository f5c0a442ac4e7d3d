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
#include "core/support/input_error.hpp"
#include "core/support/processes/mpi_session.hpp"
#include "fem_reference/hyperelastic/hyperelasticity.hpp"
#include "fem_reference/linear/linear_elasticity.hpp"
#include "msm/springs/springs.hpp"
#include "msm/statics/rest_stiffness.hpp"
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

/// Several MPI ranks solve together what a factor is not needed for. What a ball touches, and what stands on a
/// foundation, each of them solves alone.
bool is_collective(const Discretisation &discretisation) {
    return support::mpi_num_ranks() > 1 && discretisation.formulation == fem_reference::Formulation::mixed;
}

/// Whether all materials of a body have the constants of a law.
bool has_all_constants(const hyperelastic::MaterialLaw &law, const core::Problem &problem) {
    return std::ranges::all_of(problem.body->materials, [&](const core::Material &material) {
        return hyperelastic::has_constants(law, material);
    });
}

core::Solution solve(const core::Problem &problem, const std::string &law, const Discretisation &discretisation) {
    hyperelastic::LoadPath path;
    path.fractions = problem.load_case.path;
    path.tolerance = tolerance;
    if (path.fractions.empty())
        path.fractions = {1.0};
    const core::Problem dead{problem.body, core::without_follower_pressures(problem.load_case)};
    const auto &material = hyperelastic::material_law(law);
    if (!has_all_constants(material, problem))
        throw support::InputError("the materials of {} have no constants of the law {}; give them as 'laws' in an "
                                  "experiment, or leave the model out",
                                  problem.body->name, law);
    if (problem.load_case.slow_history)
        return hyperelastic::solve_history(dead, material, discretisation, tolerance, follower_pressures(problem));
    const bool has_surface_springs = problem.load_case.is_touched() || problem.load_case.foundation;
    auto found = is_collective(discretisation) && !has_surface_springs
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

/// At rims and below tools, also below those that touch.
core::BisectedProblem refine(const core::Problem &coarse) {
    if (!coarse.load_case.is_touched())
        return core::refine_at_rims_and_tools(coarse);
    std::vector<core::InteriorPlace> places;
    for (const auto &contact : coarse.load_case.contacts())
        places.push_back({contact.middle, contact.radius});
    return core::refine_at_rims_and_near(coarse, places, around_touch);
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

constexpr Discretisation linear_elements{.degree = 1}, quadratic_elements{.degree = 2, .observes_steps = true},
    mixed_elements{.degree = 2, .formulation = fem_reference::Formulation::mixed};

constexpr std::array<HyperelasticElements, 7> all_elements{
    {{.name = "fem_p1_neo_hookean",
      .summary = "neo-Hookean, linear tetrahedra (the baseline of large deformations)",
      .law = "neo_hookean",
      .discretisation = linear_elements},
     {.name = "fem_p2_neo_hookean",
      .summary = "neo-Hookean, quadratic tetrahedra",
      .law = "neo_hookean",
      .discretisation = quadratic_elements,
      .in_motion = core::Role::reference},
     {.name = "fem_p2p1_neo_hookean",
      .summary = "neo-Hookean, quadratic tetrahedra with a linear pressure (Taylor and Hood)",
      .law = "neo_hookean",
      .discretisation = mixed_elements,
      .at_rest = core::Role::reference},
     {.name = "fem_p2p1_neo_hookean_refined",
      .summary = "neo-Hookean, Taylor and Hood on meshes refined at the rims of places and below round tools (the "
                 "reference of large deformations)",
      .law = "neo_hookean",
      .discretisation = mixed_elements,
      .is_refined = true,
      .at_rest = core::Role::refined_reference},
     {.name = "fem_p2p1_ogden",
      .summary = "Ogden's law with a fit to porcine liver, Taylor and Hood: how far the law itself matters",
      .law = "ogden",
      .discretisation = mixed_elements},
     {.name = "fem_p2p1_mooney_rivlin",
      .summary = "Law of Mooney and Rivlin with a constant that the material has, Taylor and Hood",
      .law = "mooney_rivlin",
      .discretisation = mixed_elements},
     {.name = "fem_p2p1_yeoh",
      .summary = "Yeoh's law with constants that the material has, Taylor and Hood",
      .law = "yeoh",
      .discretisation = mixed_elements}}};

core::Model model(const HyperelasticElements &elements) {
    return {.name = std::string(elements.name),
            .summary = std::string(elements.summary),
            .source = "Arndt et al. 2022, The deal.II library, version 9.4, J. Numer. Math. 30(3)",
            .prepare = core::solves_each([=, law = std::string(elements.law)](const core::Problem &problem) {
                return elements.is_refined ? solve_finer(problem, law, elements.discretisation)
                                           : solve(problem, law, elements.discretisation);
            }),
            .at_rest = elements.at_rest,
            .in_motion = elements.in_motion,
            .judges = core::Regime::large,
            .only = core::Regime::large,
            .follows = core::EventSet::all(),
            .is_collective = is_collective(elements.discretisation),
            .is_wanted = [&law = hyperelastic::material_law(std::string(elements.law))](const core::Problem &problem) {
                return has_all_constants(law, problem);
            }};
}

} // namespace

/// Hyperelastic finite elements on the same tetrahedra.
ModelFamily hyperelastic() {
    return {.name = {}, .models = [](const ModelOptions & /*options*/) {
                std::vector<core::Model> models;
                for (const auto &elements : all_elements)
                    models.push_back(model(elements));
                return models;
            }};
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
