#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "msm/dynamics/spring_stepper.hpp"
#include "msm/dynamics/stepper.hpp"
#include "msm/springs/springs.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"
#include "tests/samples/bodies_with_vessels.hpp"
#include "tests/samples/covered_bodies.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

namespace covered = tests::covered;
namespace vessels = tests::vessels;

const core::Material soft{1060.0, 5000.0, 0.45};
const core::Vector3 sides{0.1, 0.08, 0.06};

std::shared_ptr<const core::Body> block() {
    return tests::make_body(tests::shaken_box_mesh(sides, {4, 3, 3}), soft);
}

} // namespace

/// Energy of the closed form on any mesh, where all strains are the same.
TEST(VesselLinesInSprings, StoreTheEnergyOfAnEvenStrain) {
    const auto body = vessels::with_vessels(block());
    const Eigen::Matrix3d f = Eigen::Matrix3d::Identity() + covered::some_strain();
    auto moved = body->mesh.points;
    for (auto &point : moved)
        point = f * point;
    const double expected = vessels::energy(*body, sides, f);
    EXPECT_NEAR(msm::vessel_lines(*body)->energy(msm::to_unknowns(moved)), expected, 1e-4 * expected);
    EXPECT_EQ(msm::vessel_lines(*block()), nullptr);
}

/// Coupled springs with a capsule and vessels swing on vector units as by the slow forces of all terms.
TEST(TermsBesideKernels, MoveABodyAsTheSlowForcesDo) {
    const auto body = vessels::with_vessels(covered::with_capsule(block()));
    const auto springs = msm::with_vessel_lines(
        msm::coupled_springs_with_volume(*body, msm::find_coupled_springs("nodal_neo_hookean")), *body);
    const auto parted = msm::part_terms(springs);
    EXPECT_EQ(parted.beside.size(), 2U);
    EXPECT_EQ(parted.beside.size() + parted.in_kernels.terms.size(), springs.terms.size());
    auto load_case = tests::empty_load_case(body->mesh);
    tests::prescribe(load_case, body->mesh, "x_min", core::Vector3::Zero());
    load_case.acceleration = {0.0, 0.0, -9.81};
    const auto held = msm::nodal_conditions({body, load_case}, springs.node_mass);
    const double critical = 2.0 / msm::largest_angular_frequency(springs, body->mesh.points, held);
    const double time_step = 0.5 * critical;
    constexpr int num_steps = 200;
    const core::RayleighDamping damping{.alpha = 2.0, .beta = 1e-5};
    msm::SpringStepper fast(body, {.springs = springs, .damping = damping, .critical_time_step = critical}, held);
    fast.prepare(time_step);
    for (int step = 0; step < num_steps; ++step)
        fast.step(time_step, 1);
    const auto size = static_cast<Eigen::Index>(3 * body->mesh.points.size());
    msm::State slow{Eigen::VectorXd::Zero(size), Eigen::VectorXd::Zero(size)};
    msm::make_stepper(springs, body->mesh.points, held, damping, msm::find_integrator("symplectic_euler"), time_step,
                      msm::StepKernel::scalar)
        .take(slow, num_steps);
    double largest = 0.0, off = 0.0;
    const auto found = fast.displacement();
    for (std::size_t i = 0; i < found.size(); ++i) {
        const core::Vector3 expected = msm::node_part(slow.displacement, static_cast<int>(i));
        largest = std::max(largest, expected.norm());
        off = std::max(off, (found[i] - expected).norm());
    }
    EXPECT_GT(largest, 1e-3);
    EXPECT_LT(off, 1e-4 * largest);
}

} // namespace livermark
