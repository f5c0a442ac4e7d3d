#include <gtest/gtest.h>

#include "results/tables/large_table.hpp"
#include "tests/samples/sample_result.hpp"

namespace livermark::results {
namespace {

/// A box that is held at x = 0, moved at its top, and pulled at its end.
Result loaded() {
    Result result = tests::sample_result();
    auto &load_case = result.problem.load_case;
    load_case.slow_history.reset();
    load_case.touching.reset();
    load_case.follows.clear();
    load_case.round_load.clear();
    load_case.round_loads.clear();
    return result;
}

std::vector<ForceCurve> of_place(const Result &result, const std::string &place) {
    auto curves = force_curves(result);
    std::erase_if(curves, [&](const ForceCurve &curve) { return curve.place != place; });
    return curves;
}

/// An even traction moves as the middle of what it pulls, where displacements are linear.
TEST(ForceCurves, HaveTheWayOfALoadAlongIt) {
    const Result result = loaded();
    const auto &[body, load_case] = result.problem;
    core::Vector3 middle = core::Vector3::Zero();
    double area = 0.0;
    core::Vector3 traction = core::Vector3::Zero();
    for (int f = 0; f < body->mesh.num_boundary_triangles(); ++f)
        if (load_case.condition[f] == core::FacetCondition::traction) {
            const double size = core::area_vector(body->mesh, f).norm();
            const auto corners = core::corners_of(body->mesh, f);
            middle += size / 3.0 * (corners[0] + corners[1] + corners[2]);
            area += size;
            traction = load_case.value[f];
        }
    middle /= area;
    const auto curves = of_place(result, "load");
    ASSERT_EQ(curves.size(), result.models.size());
    for (std::size_t m = 0; m < curves.size(); ++m) {
        const auto &path = result.models[m].solution.path;
        ASSERT_EQ(curves[m].way.size(), path.size());
        ASSERT_EQ(curves[m].force.size(), path.size());
        EXPECT_EQ(curves[m].model, result.models[m].name);
        for (std::size_t k = 0; k < path.size(); ++k) {
            EXPECT_NEAR(curves[m].force[k], load_case.path[k] * area * traction.norm(), 1e-12 * area * traction.norm());
            // The displacement of a node is a number times its place and a constant, see
            // tests/samples/sample_result.cpp.
            const auto &u = path[k].displacement;
            const auto &points = body->mesh.points;
            const core::Vector3 first = u[0].cast<double>();
            const double scale = (u[1] - u[0]).cast<double>().norm() / (points[1] - points[0]).norm();
            const core::Vector3 expected = first + scale * (middle - points[0]);
            EXPECT_NEAR(curves[m].way[k], expected.dot(traction.normalized()),
                        1e-5 * expected.norm()); // paths are floats
        }
    }
}

TEST(ForceCurves, HaveTheWayThatIsPrescribed) {
    const Result result = loaded();
    const auto curves = of_place(result, "z_max");
    ASSERT_EQ(curves.size(), result.models.size());
    for (const auto &curve : curves)
        for (std::size_t k = 0; k < curve.way.size(); ++k)
            EXPECT_DOUBLE_EQ(curve.way[k], 1e-3 * result.problem.load_case.path[k]);
}

/// A pressure on all sides pushes nothing anywhere.
TEST(ForceCurves, HaveNoLoadWithoutAResultant) {
    Result result = loaded();
    auto &load_case = result.problem.load_case;
    for (std::size_t f = 0; f < load_case.condition.size(); ++f) {
        load_case.condition[f] = core::FacetCondition::traction;
        load_case.constraint[f] = -1;
        load_case.value[f] = -100.0 * core::area_vector(result.problem.body->mesh, static_cast<int>(f)).normalized();
    }
    EXPECT_TRUE(of_place(result, "load").empty());
    result = loaded();
    result.problem.load_case.follows.assign(result.problem.load_case.condition.size(), 1);
    EXPECT_TRUE(of_place(result, "load").empty()); // what follows the surface has no direction of its own
}

} // namespace
} // namespace livermark::results
