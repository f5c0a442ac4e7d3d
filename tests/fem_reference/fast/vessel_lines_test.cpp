#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fem_reference/hyperelastic/hyperelasticity.hpp"
#include "fem_reference/linear/linear_elasticity.hpp"
#include "tests/fem_reference/hyperelastic_bodies.hpp"
#include "tests/samples/bodies_with_vessels.hpp"
#include "tests/samples/covered_bodies.hpp"

namespace livermark {
namespace {

using core::Vector3;
using fem_reference::Formulation;
using fem_reference::SolverChoice;
namespace covered = tests::covered;
namespace vessels = tests::vessels;

core::Solution linear(const core::Problem &problem, const hyperelastic::Discretisation &kind) {
    return fem_reference::solve_static(problem, kind.degree, SolverChoice::automatic, kind.formulation);
}

core::Solution hyperelastic_solution(const core::Problem &problem, const hyperelastic::Discretisation &kind) {
    return hyperelastic::solve(problem, hyperelastic::material_law("neo_hookean"), kind, {.fractions = {0.5, 1.0}}, {})
        .solution;
}

} // namespace

/// The patch test: on every kind of elements a strain that is the same everywhere stores what the closed form says.
TEST(VesselLines, StoreTheEnergyOfAnEvenStrain) {
    const auto bare = tests::soft_block();
    // Straight through the block, or the tissue would not be strained evenly.
    const auto body = vessels::with_vessels(bare, vessels::rod({-0.01, 0.02, 0.01}, {0.12, 0.09, 0.07}, 4e-3, 1e8));
    const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity(), f = identity + covered::some_strain();
    for (const auto &kind : tests::hyperelastic_kinds) {
        const double large = hyperelastic_solution(covered::deformed(body, f), kind).strain_energy -
                             hyperelastic_solution(covered::deformed(bare, f), kind).strain_energy;
        const double expected = vessels::energy(*body, tests::block_size, f);
        EXPECT_NEAR(large, expected, 1e-4 * expected)
            << kind.degree << ": the tests' own length inside has five digits";
        constexpr double little = 1e-5;
        const Eigen::Matrix3d small = identity + little * covered::some_strain();
        const double linear_energy = linear(covered::deformed(body, small), kind).strain_energy -
                                     linear(covered::deformed(bare, small), kind).strain_energy;
        const double expected_linear = vessels::energy(*body, tests::block_size, small);
        EXPECT_NEAR(linear_energy, expected_linear, 2e-4 * expected_linear) << kind.degree;
    }
}

namespace {

/// A block of 48 x 32 x 32 mm that is held at one end and pulled at the other, with a rod of 4 x 4 mm from 8 to 40 mm
/// along its middle.
struct BlockWithRod {
    static constexpr double width = 0.004, rod_modulus = 1e5;
    const Vector3 sides{0.048, 0.032, 0.032};
    const core::Material tissue{1060.0, 5000.0, 0.45};

    core::TetraMesh mesh(double bricks_in_width) const {
        const double brick = width / bricks_in_width;
        return tests::box_mesh(sides, {static_cast<int>(std::lround(sides.x() / brick)),
                                       static_cast<int>(std::lround(sides.y() / brick)),
                                       static_cast<int>(std::lround(sides.z() / brick))});
    }
    std::shared_ptr<const core::Body> resolved(int bricks_in_width) const {
        auto body = *tests::make_body(mesh(bricks_in_width), tissue);
        body.mesh.region_names = {"tissue", "rod"};
        body.materials = {tissue, {tissue.density, rod_modulus, tissue.poisson_ratio}};
        for (int t = 0; t < body.mesh.num_tetrahedra(); ++t) {
            Vector3 middle = Vector3::Zero();
            for (const int node : body.mesh.tetrahedra[t])
                middle += 0.25 * body.mesh.points[node];
            const bool is_in_rod = std::abs(middle.y() - 0.016) < 0.5 * width &&
                                   std::abs(middle.z() - 0.016) < 0.5 * width && std::abs(middle.x() - 0.024) < 0.016;
            body.mesh.region[t] = is_in_rod ? 1 : 0;
        }
        return std::make_shared<const core::Body>(std::move(body));
    }
    std::shared_ptr<const core::Body> with_line(const core::TetraMesh &on) const {
        const double radius = width / std::sqrt(std::numbers::pi); // of the same section
        return vessels::with_vessels(tests::make_body(on, tissue),
                                     vessels::rod({0.008, 0.016, 0.016}, {0.040, 0.016, 0.016}, radius, rod_modulus));
    }
    /// Work of a pull of 100 Pa at the end [J].
    double work(const std::shared_ptr<const core::Body> &body, int degree) const {
        auto load_case = tests::empty_load_case(body->mesh);
        tests::prescribe(load_case, body->mesh, "x_min", Vector3::Zero());
        tests::pull(load_case, body->mesh, "x_max", {100.0, 0.0, 0.0});
        return 2.0 * fem_reference::solve_static({body, load_case}, degree, SolverChoice::automatic,
                                                 Formulation::displacement)
                         .strain_energy;
    }
};

} // namespace

/// A rod of twenty times the modulus of the tissue makes a block stiffer by 9 %. Fibres in quadratic elements that are
/// as wide as the rod, and twice as wide, change it by as much as a mesh that has the rod itself, within a tenth.
TEST(VesselLines, StiffenABlockAsARodThatTheMeshResolves) {
    const BlockWithRod block;
    const double resolved_part =
        block.work(block.resolved(2), 2) / block.work(tests::make_body(block.mesh(1.0), block.tissue), 2);
    EXPECT_LT(resolved_part, 0.95);
    for (const double rods_in_brick : {1.0, 2.0}) {
        const auto mesh = block.mesh(1.0 / rods_in_brick);
        const double part = block.work(block.with_line(mesh), 2) / block.work(tests::make_body(mesh, block.tissue), 2);
        EXPECT_NEAR((1.0 - part) / (1.0 - resolved_part), 1.0, 0.1) << rods_in_brick;
    }
}

} // namespace livermark
