#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <vector>

#include "msm/nodal_conditions.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

using core::Vector3;

TEST(NodalConditions, MultiplyWhatIsPrescribedByTheFactorOfTheNode) {
    constexpr double free = std::numeric_limits<double>::quiet_NaN();
    const auto body = tests::make_body(tests::box_mesh({0.1, 0.1, 0.1}, {2, 2, 2}), {1060.0, 5000.0, 0.45});
    auto load_case = tests::empty_load_case(body->mesh);
    tests::prescribe(load_case, body->mesh, "z_max", {free, 0.0, -0.01});
    tests::pull(load_case, body->mesh, "x_max", {1.0, 0.0, 0.0});
    for (const auto &point : body->mesh.points)
        load_case.node_factor.push_back(0.5 + point.x());
    const auto conditions = msm::nodal_conditions({body, load_case}, std::vector<double>(body->mesh.points.size()));
    Vector3 pulled = Vector3::Zero();
    for (int node = 0; node < body->mesh.num_nodes(); ++node) {
        pulled += conditions.force[node];
        if (body->mesh.points[node].z() < 0.1 - 1e-9)
            continue;
        EXPECT_TRUE(std::isnan(conditions.displacement[node].x()));
        EXPECT_EQ(conditions.displacement[node].y(), 0.0);
        EXPECT_EQ(conditions.displacement[node].z(), load_case.node_factor[node] * -0.01);
    }
    EXPECT_LT((pulled - Vector3(0.01, 0.0, 0.0)).norm(), 1e-15); // loads have no factor
}

TEST(NodalConditions, AddTheShiftOfTheNodeToWhatIsPrescribed) {
    constexpr double free = std::numeric_limits<double>::quiet_NaN();
    const auto body = tests::make_body(tests::box_mesh({0.1, 0.1, 0.1}, {2, 2, 2}), {1060.0, 5000.0, 0.45});
    auto load_case = tests::empty_load_case(body->mesh);
    tests::prescribe(load_case, body->mesh, "z_max", {free, 0.0, -0.01});
    for (const auto &point : body->mesh.points)
        load_case.node_shift.emplace_back(0.1 * point);
    const auto conditions = msm::nodal_conditions({body, load_case}, std::vector<double>(body->mesh.points.size()));
    for (int node = 0; node < body->mesh.num_nodes(); ++node) {
        const auto &point = body->mesh.points[node];
        EXPECT_TRUE(std::isnan(conditions.displacement[node].x()));
        if (point.z() < 0.1 - 1e-9) {
            EXPECT_TRUE(conditions.displacement[node].array().isNaN().all());
        } else {
            EXPECT_EQ(conditions.displacement[node].y(), 0.1 * point.y());
            EXPECT_EQ(conditions.displacement[node].z(), -0.01 + 0.1 * point.z());
        }
    }
    const auto half = core::scaled(load_case, 0.5);
    EXPECT_EQ(half.prescribed_at(body->mesh.num_boundary_triangles() - 1, 0).array().isNaN().any(), true);
    EXPECT_EQ(half.node_shift.back(), Vector3(0.05 * body->mesh.points.back()));
    EXPECT_FALSE(core::are_statically_equal(load_case, half));
    auto still = tests::empty_load_case(body->mesh);
    tests::prescribe(still, body->mesh, "z_max", Vector3::Zero());
    EXPECT_FALSE(core::is_driven(still));
    still.node_shift = load_case.node_shift;
    EXPECT_TRUE(core::is_driven(still));
}

} // namespace
} // namespace livermark
