#include <gtest/gtest.h>
#include <memory>
#include <utility>
#include <vector>

#include "core/support/input_error.hpp"
#include "studies/models/model_table.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::models {
namespace {

/// Models share what they have in common on a body only as long as they are of one table.
struct Elements {
    explicit Elements(const std::shared_ptr<const core::Body> &body)
        : on_mesh(support::find_named(models, "fem_p2p1", "model").prepare(body, nullptr)),
          refined(support::find_named(models, "fem_p2p1_refined", "model").prepare(body, nullptr)) {}

    std::vector<core::Model> models = all_models();
    std::unique_ptr<core::PreparedModel> on_mesh, refined;
};

core::LoadCase pulled(const core::TetraMesh &mesh, const core::Vector3 &traction) {
    auto load_case = tests::empty_load_case(mesh);
    tests::prescribe(load_case, mesh, "x_min", core::Vector3::Zero());
    tests::pull(load_case, mesh, "x_max", traction);
    return load_case;
}

/// The refined elements begin with what those on the mesh found last, if it is of the same load cases.
TEST(SharedElements, FindTheSolutionsOfElementsThatAreAlone) {
    const auto body = tests::make_body(tests::box_mesh({0.06, 0.05, 0.04}, {3, 2, 2}), {1000.0, 5000.0, 0.45});
    const auto along = pulled(body->mesh, {10.0, 0.0, 0.0}), across = pulled(body->mesh, {0.0, 5.0, 0.0});
    using LoadCases = std::vector<core::LoadCase>;
    const LoadCases first{along, across}, second{across, along}, fewer{along};
    const std::vector<std::pair<LoadCases, LoadCases>> turns{{first, first}, {first, second}, {second, fewer}};
    Elements shared(body);
    for (const auto &[before, load_cases] : turns) {
        const auto on_mesh = shared.on_mesh->solve(before);
        const auto refined = shared.refined->solve(load_cases);
        const auto alone = Elements(body).refined->solve(load_cases);
        const auto on_mesh_alone = Elements(body).on_mesh->solve(before);
        for (std::size_t c = 0; c < before.size(); ++c)
            EXPECT_EQ(on_mesh[c].displacement, on_mesh_alone[c].displacement);
        ASSERT_EQ(refined.size(), load_cases.size());
        for (std::size_t c = 0; c < load_cases.size(); ++c) {
            EXPECT_EQ(refined[c].status, core::SolutionStatus::ok) << refined[c].message;
            EXPECT_EQ(refined[c].displacement, alone[c].displacement);
            EXPECT_EQ(refined[c].strain_energy, alone[c].strain_energy);
        }
    }
}

} // namespace
} // namespace livermark::models
