#include <cmath>
#include <gtest/gtest.h>
#include <set>

#include "core/mesh/refinement.hpp"
#include "msm/spring_law.hpp"
#include "msm/springs/springs.hpp"
#include "studies/models/model_table.hpp"
#include "tests/samples/test_meshes.hpp"

/// Bodies whose tetrahedra have moduli of their own, core::Body::modulus_factor.
namespace livermark::models {
namespace {

using core::Vector3;
using BodyPointer = std::shared_ptr<const core::Body>;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
const Vector3 size(0.02, 0.02, 0.04);
const std::array bricks{3, 3, 6};

BodyPointer block(const core::Material &material = {1060.0, 5e3, 0.45}) {
    return tests::make_body(tests::box_mesh(size, bricks), material);
}

Vector3 middle_of(const core::TetraMesh &mesh, std::size_t t) {
    Vector3 middle = Vector3::Zero();
    for (const int node : mesh.tetrahedra[t])
        middle += 0.25 * mesh.points[node];
    return middle;
}

template <class Factor> BodyPointer with_map(const BodyPointer &body, Factor factor) {
    auto mapped = *body;
    mapped.modulus_factor.clear();
    for (std::size_t t = 0; t < mapped.mesh.tetrahedra.size(); ++t)
        mapped.modulus_factor.push_back(factor(middle_of(mapped.mesh, t)));
    return std::make_shared<const core::Body>(std::move(mapped));
}

core::Problem bent(const BodyPointer &body, core::Regime regime, double traction = 20.0) {
    auto load_case = tests::empty_load_case(body->mesh);
    load_case.regime = regime;
    tests::prescribe(load_case, body->mesh, "z_min", Vector3::Zero());
    tests::pull(load_case, body->mesh, "z_max", traction * Vector3(0.3, -0.2, 1.0));
    return {body, load_case};
}

/// Relative distance of the displacements.
double difference(const core::Solution &a, const core::Solution &b) {
    double squares = 0.0, all = 0.0;
    for (std::size_t i = 0; i < a.displacement.size(); ++i) {
        squares += (a.displacement[i] - b.displacement[i]).squaredNorm();
        all += a.displacement[i].squaredNorm();
    }
    return std::sqrt(squares / all);
}

class EveryModel : public testing::TestWithParam<core::Regime> {};

/// A factor of 2 on all tetrahedra is twice the Young's modulus.
TEST_P(EveryModel, TakesAnEvenMapAsAModulus) {
    const auto soft = block({1060.0, 2.5e3, 0.45});
    const auto mapped = bent(with_map(soft, [](const Vector3 &) { return 2.0; }), GetParam());
    const auto plain = bent(block(), GetParam());
    int num_compared = 0;
    for (const auto &model : all_models()) {
        if (!model.takes_part_in(plain) || model.role_at_rest(GetParam()) == core::Role::refined_reference)
            continue;
        const auto solution = model.solve(mapped), expected = model.solve(plain);
        EXPECT_EQ(solution.status, expected.status) << model.name;
        if (expected.status != core::SolutionStatus::ok)
            continue;
        EXPECT_LT(difference(solution, expected), 1e-6) << model.name;
        EXPECT_NEAR(solution.strain_energy, expected.strain_energy, 1e-6 * std::abs(expected.strain_energy))
            << model.name;
        ++num_compared;
    }
    EXPECT_GT(num_compared, 15);
}

INSTANTIATE_TEST_SUITE_P(Regimes, EveryModel, testing::Values(core::Regime::small, core::Regime::large),
                         [](const auto &info) { return std::string(core::to_string(info.param)); });

/// Models that know tetrahedra alone see no difference between two regions and a map with two values. Means around
/// nodes do: they never cross from a region to another.
TEST(StiffnessMap, IsTwoRegionsForModelsOfTetrahedra) {
    const auto body = block();
    const auto is_stiff = [](const Vector3 &middle) { return middle.z() > 0.02 && middle.x() > 0.0067; };
    auto two = *body;
    two.mesh.region_names.emplace_back("stiff");
    two.materials.push_back({1060.0, 20e3, 0.45});
    for (std::size_t t = 0; t < two.mesh.tetrahedra.size(); ++t)
        two.mesh.region[t] = is_stiff(middle_of(two.mesh, t)) ? 1 : 0;
    const auto regions = std::make_shared<const core::Body>(std::move(two));
    const auto mapped = with_map(body, [&](const Vector3 &middle) { return is_stiff(middle) ? 4.0 : 1.0; });
    for (const auto regime : {core::Regime::small, core::Regime::large})
        for (const auto *name : {"fem_p1", "fem_p2", "fem_p1_neo_hookean", "fem_p2_neo_hookean", "lloyd", "van_gelder",
                                 "van_gelder_tetrahedral_volume"}) {
            const auto known = all_models();
            const auto found = std::ranges::find(known, name, &core::Model::name);
            ASSERT_NE(found, known.end()) << name;
            const auto expected = bent(regions, regime);
            if (!found->takes_part_in(expected))
                continue;
            EXPECT_LT(difference(found->solve(bent(mapped, regime)), found->solve(expected)), 1e-7) << name;
        }
}

/// Layers of a bar at Poisson's ratio 0 are stretched one after the other: u(z) = integral of traction / E.
TEST(StiffnessMap, StretchesAGradedBarAsItsIntegralSays) {
    constexpr double traction = 10.0, young_modulus = 5e3;
    // The integral of 1 / (1 + 2 z / L) over the length is L / 2 ln 3.
    const double expected = traction / young_modulus * size.z() / 2.0 * std::log(3.0);
    double last = nan;
    for (const int layers : {2, 4, 8}) {
        const auto plain = tests::make_body(tests::box_mesh(size, {2, 2, layers}), {1060.0, young_modulus, 0.0});
        const auto body = with_map(plain, [](const Vector3 &middle) { return 1.0 + 2.0 * middle.z() / size.z(); });
        auto load_case = tests::empty_load_case(body->mesh);
        tests::prescribe(load_case, body->mesh, "z_min", Vector3::Zero());
        tests::pull(load_case, body->mesh, "z_max", {0.0, 0.0, traction});
        const auto solution = support::find_named(all_models(), "fem_p2", "model").solve({body, load_case});
        double top = 0.0, num_top = 0.0;
        for (int node = 0; node < body->mesh.num_nodes(); ++node)
            if (body->mesh.points[node].z() > size.z() - 1e-9) {
                top += solution.displacement[node].z();
                num_top += 1.0;
            }
        const double error = std::abs(top / num_top / expected - 1.0);
        EXPECT_TRUE(std::isnan(last) || error < 0.5 * last) << layers << ": " << error << " after " << last;
        last = error;
    }
    EXPECT_LT(last, 0.01);
}

/// Under an even strain springs and elements store the energy of the mean modulus, however it varies.
TEST(StiffnessMap, StoresTheEnergyOfTheMeanUnderAnEvenStrain) {
    const auto plain = block();
    const auto body = with_map(plain, [](const Vector3 &middle) {
        return 1.0 + 0.6 * std::sin(300.0 * middle.x()) * std::cos(200.0 * middle.z());
    });
    const auto volumes = core::tetrahedron_volumes(body->mesh);
    double sum = 0.0, whole = 0.0;
    for (std::size_t t = 0; t < volumes.size(); ++t) {
        sum += body->modulus_factor[t] * volumes[t];
        whole += volumes[t];
    }
    Eigen::Matrix3d f;
    f << 1.02, 0.01, 0.0, -0.005, 0.99, 0.02, 0.01, 0.0, 1.01;
    Eigen::VectorXd x(3 * body->mesh.num_nodes());
    for (int node = 0; node < body->mesh.num_nodes(); ++node)
        x.segment<3>(3 * node) = f * body->mesh.points[node];
    for (const auto &coupled : msm::all_coupled_springs()) {
        const auto energy = [&](const core::Body &of) {
            const auto volume = msm::volume_beside_coupled_springs(of, coupled);
            return msm::coupled_springs(of, coupled)->energy(x) + (volume ? volume->energy(x) : 0.0);
        };
        // That of elongations depends on the shape of tetrahedra as well.
        const double tolerance = coupled.measure == msm::StrainMeasure::elongation ? 1e-5 : 1e-9;
        EXPECT_NEAR(energy(*body), sum / whole * energy(*plain), tolerance * energy(*plain)) << coupled.name;
    }
    for (const auto &law : msm::all_spring_laws()) {
        const auto trace = [&](const core::Body &of) {
            const auto springs = msm::spring_network(of, law);
            double result = 0.0;
            for (std::size_t s = 0; s < springs.edges.size(); ++s)
                result += springs.stiffness[s] * springs.rest_length[s] * springs.rest_length[s];
            return result;
        };
        if (law.name == "patch" || law.name == "van_gelder" ||
            law.name == "uniform") { // which have the trace of the solid
            EXPECT_NEAR(trace(*body), sum / whole * trace(*plain), 1e-9 * trace(*plain)) << law.name;
        }
    }
}

TEST(StiffnessMap, IsThatOfTheParentsOnAFinerMesh) {
    const auto body = with_map(block(), [](const Vector3 &middle) { return 1.0 + 20.0 * middle.x(); });
    const auto fine = core::refine(*body);
    ASSERT_EQ(fine.modulus_factor.size(), fine.mesh.tetrahedra.size());
    const auto volumes = core::tetrahedron_volumes(body->mesh), fine_volumes = core::tetrahedron_volumes(fine.mesh);
    double coarse_sum = 0.0, fine_sum = 0.0;
    for (std::size_t t = 0; t < volumes.size(); ++t)
        coarse_sum += body->modulus_factor[t] * volumes[t] * middle_of(body->mesh, t).x();
    for (std::size_t t = 0; t < fine_volumes.size(); ++t)
        fine_sum += fine.modulus_factor[t] * fine_volumes[t] * middle_of(fine.mesh, t).x();
    EXPECT_NEAR(fine_sum, coarse_sum, 1e-12 * coarse_sum);
}

} // namespace
} // namespace livermark::models
