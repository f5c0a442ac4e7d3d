#include "studies/sensitivity/soft_support.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <numeric>

#include "models/model_table.hpp"
#include "studies/sensitivity/patient.hpp"
#include "support/known_names.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::studies {
namespace {

using core::Vector3;

constexpr double area = 0.06 * 0.05, length = 0.08; // m^2, m

/// A bar along x, held at one end.
core::Problem bar(double young_modulus, double poisson_ratio) {
    const auto body =
        tests::make_body(tests::box_mesh({length, 0.06, 0.05}, {4, 3, 3}), {1000.0, young_modulus, poisson_ratio});
    auto load_case = tests::empty_load_case(body->mesh);
    tests::prescribe(load_case, body->mesh, "x_min", Vector3::Zero());
    return {body, load_case};
}

core::Solution solve(const std::string &model, const core::Problem &problem) {
    const auto known = models::all_models();
    return support::find_named(known, model, "model").solve(problem);
}

/// Area mean over a side of the bar.
Vector3 mean_at(const core::Problem &nominal, const core::Solution &solution, double x) {
    Vector3 sum = Vector3::Zero();
    int count = 0;
    for (int i = 0; i < nominal.body->mesh.num_nodes(); ++i)
        if (std::abs(nominal.body->mesh.points[i].x() - x) < 1e-9) {
            sum += solution.displacement[i];
            ++count;
        }
    return sum / count;
}

/// Two springs in series: sigma L / E of the bar and sigma / k of the support.
TEST(SoftSupport, AddsItsOwnComplianceInSeries) {
    constexpr double traction = 40.0;
    auto nominal = bar(5000.0, 0.0);
    tests::pull(nominal.load_case, nominal.body->mesh, "x_max", {traction, 0.0, 0.0});
    for (const auto *model : {"fem_p1", "fem_p2p1"})
        for (const double stiffness : {1e4, 1e5, 1e6}) {
            const auto solution = solve(model, with_soft_support(nominal, stiffness));
            ASSERT_EQ(solution.status, core::SolutionStatus::ok) << solution.message;
            EXPECT_NEAR(mean_at(nominal, solution, 0.0).x(), traction / stiffness, 0.03 * traction / stiffness)
                << model;
            const double expected = traction * length / 5000.0 + traction / stiffness;
            EXPECT_NEAR(mean_at(nominal, solution, length).x(), expected, 0.01 * expected) << model;
        }
}

/// A body as good as rigid under its weight across the support moves by F / (k_t A).
TEST(SoftSupport, GivesWayAlongTheSurfaceByItsShearRatio) {
    auto nominal = bar(1e9, 0.0);
    nominal.load_case.acceleration = {0.0, 0.5, 0.0};
    constexpr double stiffness = 1e6;
    const auto solution = solve("fem_p1", with_soft_support(nominal, stiffness));
    const double force = 0.5 * 1000.0 * length * area;
    const double expected = force / (support_shear_ratio * stiffness * area);
    EXPECT_NEAR(mean_at(nominal, solution, 0.0).y(), expected, 0.03 * expected);
}

TEST(SoftSupport, TendsToWhatIsHeldFirmly) {
    auto nominal = bar(5000.0, 0.45);
    tests::pull(nominal.load_case, nominal.body->mesh, "x_max", {0.0, 20.0, 0.0});
    const auto firm = solve("fem_p1", nominal), nearly = solve("fem_p1", with_soft_support(nominal, 1e10));
    EXPECT_NEAR(mean_at(nominal, nearly, length).y(), mean_at(nominal, firm, length).y(),
                1e-3 * mean_at(nominal, firm, length).y());
}

TEST(SoftSupport, KeepsNodesAndFacetsOfTheBodyAndClosesTheSurface) {
    auto nominal = bar(5000.0, 0.3);
    tests::pull(nominal.load_case, nominal.body->mesh, "x_max", {40.0, 0.0, 0.0});
    const auto problem = with_soft_support(nominal, 1e6);
    const auto &before = nominal.body->mesh, &after = problem.body->mesh;
    ASSERT_TRUE(std::equal(before.points.begin(), before.points.end(), after.points.begin()));
    ASSERT_TRUE(std::equal(before.tetrahedra.begin(), before.tetrahedra.end(), after.tetrahedra.begin()));
    for (int f = 0; f < before.num_boundary_triangles(); ++f)
        if (!nominal.load_case.is_constrained(f)) {
            EXPECT_EQ(before.boundary_triangles[f], after.boundary_triangles[f]);
        }
    EXPECT_EQ(core::outer_faces(after.tetrahedra).size(), after.boundary_triangles.size());
    Vector3 closed = Vector3::Zero();
    for (int f = 0; f < after.num_boundary_triangles(); ++f)
        closed += core::area_vector(after, f);
    EXPECT_LT(closed.norm(), 1e-15);
    EXPECT_EQ(held_facets(problem.load_case), held_facets(nominal.load_case));
    EXPECT_EQ(problem.load_case.num_facets(), after.boundary_triangles.size());
    EXPECT_EQ(after.boundary_patch.size(), after.boundary_triangles.size());
    for (const double volume : core::tetrahedron_volumes(after))
        EXPECT_GT(volume, 0.0);
}

} // namespace
} // namespace livermark::studies
