#include <gtest/gtest.h>

#include "results/tables/table.hpp"
#include "tests/samples/records/sample_result.hpp"

namespace livermark::results {
namespace {

/// A box that is held at x = 0, moved at its top, and pulled at its end.
Result loaded() {
    Result result = tests::sample_result();
    auto &load_case = result.problem.load_case;
    load_case.slow_history.reset();
    load_case.touching.reset();
    for (int f = 0; f < load_case.num_facets(); ++f)
        if (load_case.is_loaded(f) && load_case.value[f].isZero(0.0))
            load_case.free_facet(f);
    for (auto &condition : load_case.conditions) {
        condition.round.reset();
        if (condition.kind == core::ConditionKind::pressure)
            condition.kind = core::ConditionKind::traction;
    }
    return result;
}

std::vector<ForceCurve> curves_at(const Result &result, const std::string &place) {
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
        if (load_case.is_loaded(f)) {
            const double size = core::area_vector(body->mesh, f).norm();
            const auto corners = core::corners_of(body->mesh, f);
            middle += size / 3.0 * (corners[0] + corners[1] + corners[2]);
            area += size;
            traction = load_case.value[f];
        }
    middle /= area;
    const auto curves = curves_at(result, "load");
    ASSERT_EQ(curves.size(), result.models.size());
    for (std::size_t m = 0; m < curves.size(); ++m) {
        const auto &path = result.models[m].solution.path;
        ASSERT_EQ(curves[m].way.size(), path.size());
        ASSERT_EQ(curves[m].force.size(), path.size());
        EXPECT_EQ(curves[m].model, result.models[m].name);
        for (std::size_t k = 0; k < path.size(); ++k) {
            EXPECT_NEAR(curves[m].force[k], load_case.path[k] * area * traction.norm(), 1e-12 * area * traction.norm());
            // The displacement of a node is a number times its place and a constant, see
            // tests/samples/records/sample_result.cpp.
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
    const auto curves = curves_at(result, "z_max");
    ASSERT_EQ(curves.size(), result.models.size());
    for (const auto &curve : curves)
        for (std::size_t k = 0; k < curve.way.size(); ++k)
            EXPECT_DOUBLE_EQ(curve.way[k], 1e-3 * result.problem.load_case.path[k]);
}

/// A pressure on all sides pushes nothing anywhere.
TEST(ForceCurves, HaveNoLoadWithoutAResultant) {
    Result result = loaded();
    auto &load_case = result.problem.load_case;
    const auto on_all_sides = static_cast<int>(load_case.conditions.size());
    load_case.conditions.push_back({"all sides", core::ConditionKind::traction});
    for (int f = 0; f < load_case.num_facets(); ++f) {
        load_case.condition_on[f] = on_all_sides;
        load_case.value[f] = -100.0 * core::area_vector(result.problem.body->mesh, static_cast<int>(f)).normalized();
    }
    EXPECT_TRUE(curves_at(result, "load").empty());
    result = loaded();
    for (auto &condition : result.problem.load_case.conditions)
        if (condition.is_given_load())
            condition.kind = core::ConditionKind::pressure;
    EXPECT_TRUE(curves_at(result, "load").empty()); // what follows the surface has no direction of its own
}

} // namespace
} // namespace livermark::results
