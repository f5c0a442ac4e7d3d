#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <vector>

#include "msm/nodal_conditions.hpp"
#include "tests/test_meshes.hpp"

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

} // namespace
} // namespace livermark
