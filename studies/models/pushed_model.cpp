#include "studies/models/pushed_model.hpp"

#include <string>

#include "core/mesh/refinement.hpp"
#include "fem_reference/hyperelastic/hyperelasticity.hpp"
#include "fem_reference/linear/linear_elasticity.hpp"
#include "msm/statics/rest_stiffness.hpp"
#include "studies/models/mass_spring_model.hpp"

namespace livermark::models {

namespace {

/// As of the linear reference.
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
