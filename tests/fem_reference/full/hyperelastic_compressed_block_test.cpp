#include <gtest/gtest.h>

#include <cmath>
#include <fmt/format.h>

#include "fem_reference/hyperelastic/paths/load_path.hpp"
#include "tests/fem_reference/hyperelastic_bodies.hpp"
#include "tests/samples/calculix_neo_hooke.hpp"

namespace livermark {

namespace {

using core::Vector3;

/// A quarter of the compressed block, a cube of side 1: a pressure acts on the square of half the side at the axis of
/// the whole block, whose top does not move sideways and whose bottom slides. As the top moves up and down only, a
/// pressure that follows it is the same as a dead load.
/// (S. Reese, P. Wriggers, B. D. Reddy 2000, A new locking-free brick element technique for large deformation problems
/// in elasticity, Comput. Struct. 75(3), 291-304)
struct CompressedBlock {
    double mu, lambda, pressure; ///< one unit

    core::Material material() const {
        return {1.0, mu * (3.0 * lambda + 2.0 * mu) / (lambda + mu), 0.5 * lambda / (lambda + mu)};
    }

    /// How deep the axis is pressed in at parts of the pressure, over the height.
    /// @param bricks  of six tetrahedra along a side, even
    std::vector<double> compression(const hyperelastic::MaterialLaw &law, int bricks,
                                    const std::vector<double> &fractions) const {
        const auto body = tests::make_body(tests::box_mesh({1.0, 1.0, 1.0}, {bricks, bricks, bricks}), material());
        const auto &mesh = body->mesh;
        const hyperelastic::Elements elements(body, 2, fem_reference::Formulation::mixed, law,
                                              hyperelastic::TetrahedronRule::fourteen_points);
        const auto &points = elements.system().points;
        fem_reference::DofConditions conditions;
        conditions.prescribed.assign(3 * points.size(), tests::free_component);
        conditions.constraint.assign(3 * points.size(), -1);
        conditions.load.assign(3 * points.size(), 0.0);
        std::size_t axis = points.size();
        for (std::size_t node = 0; node < points.size(); ++node) {
            const Vector3 &x = points[node];
            for (int i = 0; i < 3; ++i)
                if (x[i] == 0.0 || (i < 2 && x.z() == 1.0))
                    conditions.prescribed[3 * node + i] = 0.0;
            if (x == Vector3::UnitZ())
                axis = node;
        }
        std::vector<double> on_facet;
        for (const auto &[a, b, c] : mesh.boundary_triangles) {
            const Vector3 middle = (mesh.points[a] + mesh.points[b] + mesh.points[c]) / 3.0;
            on_facet.push_back(middle.z() == 1.0 && middle.x() < 0.5 && middle.y() < 0.5 ? pressure : 0.0);
        }
        const auto path = hyperelastic::follow(elements, conditions, 0, on_facet, {.fractions = fractions});
        EXPECT_EQ(path.status, core::SolutionStatus::ok) << path.message;
        std::vector<double> result;
        for (const auto &point : path.points)
            result.push_back(-point.state.displacement[3 * axis + 2]);
        return result;
    }
};

} // namespace

/// Under eighty times the pressure p0 = 4 of the paper. What others found: about 0.70 of the height at the whole
/// pressure, with the same energy in linear tetrahedra with a stabilised change of volume, 16 to a side (G. Scovazzi,
/// R. Zorrilla, R. Rossi 2023, A kinematically stabilized linear tetrahedral finite element for compressible and nearly
/// incompressible finite elasticity, Comput. Methods Appl. Mech. Eng. 412, 10.1016/j.cma.2023.116076, figure 14); and
/// the curve below, with these elements written again for Abaqus (github.com/tengzhang48/abaqus_ufl,
/// paper_examples/stabilized_tet4). Poisson's ratio is 0.4999.
TEST(HyperelasticCompressedBlock, IsCompressedAsPublished) {
    const CompressedBlock block{80.194, 400889.806, 320.0};
    const std::vector<double> fractions{0.09, 0.34, 0.59, 0.84, 1.0};
    const std::vector<double> published{0.0792461, 0.2981574, 0.4895191, 0.6316032, 0.6962436};
    const auto &law = hyperelastic::material_law("neo_hookean");
    const auto coarse = block.compression(law, 4, fractions), fine = block.compression(law, 8, fractions);
    RecordProperty("compression", fmt::format("{:.5f}; {:.5f}", fmt::join(coarse, " "), fmt::join(fine, " ")));
    ASSERT_EQ(fine.size(), published.size());
    for (std::size_t i = 0; i < published.size(); ++i) {
        EXPECT_NEAR(fine[i], published[i], 0.01 * published[i]);
        EXPECT_NEAR(fine[i], coarse[i], 0.015 * fine[i]);
    }
    EXPECT_NEAR(fine.back(), 0.70, 0.01);
}

/// The same block under a pressure of 5.6 shear moduli, with the energy that Ikarus has
/// (github.com/ikarus-project/ikarus, its test of displacement-pressure elements): four quadratic bricks with a
/// continuous linear pressure along a side are compressed by 39.92020798 of 50, two by 39.97523916.
TEST(HyperelasticCompressedBlock, IsCompressedAsInIkarus) {
    const CompressedBlock block{1.61148, 499.92568, 9.0};
    const std::vector<double> fractions{0.2, 0.4, 0.6, 0.8, 1.0};
    const auto law = tests::calculix_neo_hooke();
    const auto coarse = block.compression(law, 4, fractions), fine = block.compression(law, 8, fractions);
    RecordProperty("compression", fmt::format("{:.5f}; {:.5f}", fmt::join(coarse, " "), fmt::join(fine, " ")));
    const double published = 39.92020798 / 50.0;
    EXPECT_NEAR(fine.back(), published, 0.02 * published);
    EXPECT_LT(std::abs(fine.back() - published), 0.5 * std::abs(coarse.back() - published));
}

} // namespace livermark
