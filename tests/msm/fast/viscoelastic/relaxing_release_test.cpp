#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <complex>
#include <gtest/gtest.h>
#include <limits>
#include <memory>
#include <vector>

#include "msm/dynamics/release.hpp"
#include "msm/dynamics/stepper.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/springs/coupled_springs.hpp"
#include "msm/springs/spring_network.hpp"
#include "msm/viscoelastic/relaxing_stepper.hpp"
#include "msm/viscoelastic/slow_history.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

using core::Vector3;

constexpr double endless = 1e15; // [s]

/// A rod that is held at one end, pulled at the other, held until its stress has faded, and let go.
struct PulledRod {
    explicit PulledRod(const core::PronySeries &series, double hold = endless) {
        const auto body = tests::make_body(tests::box_mesh({0.06, 0.03, 0.03}, {2, 1, 1}), {1060.0, 5e3, 0.25});
        auto load_case = tests::empty_load_case(body->mesh);
        load_case.name = "rod";
        tests::prescribe(load_case, body->mesh, "x_min", Vector3::Zero());
        tests::pull(load_case, body->mesh, "x_max",
                    {0.5, 0.0, 0.25}); // it moves by less than a thousandth of its length
        std::vector<double> times{0.0, 1.0};
        for (double time = 2.0; time < std::min(1.0 + hold, 100.0); time *= 2.0)
            times.push_back(time);
        times.push_back(1.0 + hold);
        std::vector<double> factors(times.size(), 1.0);
        factors.front() = 0.0;
        load_case.slow_history = core::SlowHistory{.relaxation = series, .times = times, .factors = factors};
        const int last = static_cast<int>(body->mesh.points.size()) - 1;
        load_case.release = core::Release{
            .num_steps = 100, .output_interval = 0.004, .damping = {}, .probes = {{.name = "end", .node = last}}};
        problem = {body, load_case};
    }

    core::History motion(const msm::ElasticBody &elastic, const msm::TimeStepping &choice = {}) const {
        const auto &points = problem.body->mesh.points;
        const auto followed = msm::follow_history(elastic, problem, elastic.node_mass);
        const auto conditions = msm::nodal_conditions(problem, elastic.node_mass);
        const auto plan = msm::plan_steps(problem, msm::largest_angular_frequency(elastic, points, conditions), choice);
        const auto free =
            msm::nodal_conditions({problem.body, core::without_tractions(problem.load_case)}, elastic.node_mass);
        return msm::release(problem, elastic, free, followed.end.displacement, plan, followed.points);
    }
    msm::ElasticBody springs() const { return msm::spring_network(*problem.body, msm::all_spring_laws().front()); }

    core::Problem problem;
};

/// Where a mode of that stiffness over its mass is after it was let go from 1, of a body that relaxes as a whole and
/// has relaxed: (x, v, h)' = A (x, v, h), an equation of third order.
double standard_linear_solid(double square, double modulus, double tau, double time) {
    Eigen::Matrix3d matrix;
    matrix << 0.0, 1.0, 0.0, -(1.0 - modulus) * square, 0.0, -1.0, 0.0, modulus * square, -1.0 / tau;
    const Eigen::EigenSolver<Eigen::Matrix3d> eigen(matrix);
    const Eigen::Vector3cd parts =
        eigen.eigenvectors().partialPivLu().solve(Eigen::Vector3d(1.0, 0.0, 0.0).cast<std::complex<double>>());
    const Eigen::Vector3cd grown = (eigen.eigenvalues() * time).array().exp() * parts.array();
    return (eigen.eigenvectors() * grown)[0].real();
}

/// The motion of the probe, mode by mode.
std::vector<Vector3> exact_motion(const PulledRod &rod, const msm::ElasticBody &elastic, double modulus, double tau) {
    const auto &points = rod.problem.body->mesh.points;
    const auto conditions = msm::nodal_conditions(rod.problem, elastic.node_mass);
    const auto equation = msm::elastic_motion(elastic, points, conditions, {});
    const auto size = equation.mass.size();
    std::vector<Eigen::Index> free;
    for (Eigen::Index i = 0; i < size; ++i)
        if (std::isnan(conditions.displacement[static_cast<std::size_t>(i / 3)][i % 3]))
            free.push_back(i);
    Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(size, size);
    for (const auto &term : elastic.terms)
        stiffness += Eigen::MatrixXd(term->hessian(msm::to_unknowns(points), msm::Tangent::exact));
    const Eigen::MatrixXd k = stiffness(free, free);
    const Eigen::MatrixXd mass = equation.mass(free).asDiagonal();
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> modes(k, mass);
    const Eigen::VectorXd load = msm::to_unknowns(conditions.force)(free);
    const Eigen::VectorXd start = k.ldlt().solve(load) / (1.0 - modulus);
    const Eigen::VectorXd amplitude = modes.eigenvectors().transpose() * mass * start;
    std::vector<Vector3> motion;
    const auto &release = *rod.problem.load_case.release;
    for (int record = 0; record <= release.num_steps; ++record) {
        Eigen::VectorXd now = amplitude;
        for (Eigen::Index m = 0; m < now.size(); ++m)
            now[m] *= standard_linear_solid(modes.eigenvalues()[m], modulus, tau, record * release.output_interval);
        Eigen::VectorXd all = Eigen::VectorXd::Zero(size);
        all(free) = modes.eigenvectors() * now;
        motion.emplace_back(all.segment<3>(3 * static_cast<Eigen::Index>(release.probes.front().node)));
    }
    return motion;
}

/// Over the root mean square of the expected motion.
double error_of(const core::History &history, const std::vector<Vector3> &expected) {
    double difference = 0.0, size = 0.0;
    for (std::size_t k = 0; k < expected.size(); ++k) {
        difference += (history.displacement[k] - expected[k]).squaredNorm();
        size += expected[k].squaredNorm();
    }
    return std::sqrt(difference / size);
}

TEST(RelaxingRelease, RingsDownAsAStandardLinearSolidInEveryKernel) {
    for (const double tau : {0.01, 0.1, 1.0}) {
        const double modulus = 0.4;
        const PulledRod rod({"one", {modulus}, {tau}});
        const auto springs = rod.springs();
        const auto expected = exact_motion(rod, springs, modulus, tau);
        for (const auto kernel : {msm::StepKernel::scalar, msm::StepKernel::simd_double, msm::StepKernel::simd_float}) {
            const auto history = rod.motion(springs, {.time_step = 5e-4, .kernel = kernel});
            EXPECT_EQ(history.kernel, msm::to_string(kernel));
            EXPECT_LT(error_of(history, expected), 5e-3) << history.kernel << " " << tau;
        }
    }
}

TEST(RelaxingRelease, LosesEnergyAndAddsNone) {
    const PulledRod rod({"two", {0.3, 0.3}, {0.02, 0.5}}, 0.1);
    for (const auto *name : {"nodal_springs", "nodal_neo_hookean_f"}) {
        const auto elastic = msm::coupled_springs_with_volume(*rod.problem.body, msm::find_coupled_springs(name));
        const auto history = rod.motion(elastic, {.kernel = msm::StepKernel::simd_double});
        const auto energy = [&](std::size_t k) { return history.kinetic_energy[k] + history.strain_energy[k]; };
        for (std::size_t k = 1; k < history.time.size(); ++k)
            ASSERT_LT(energy(k), energy(k - 1) + 5e-3 * energy(0)) << name << " at " << history.time[k];
        EXPECT_LT(energy(history.time.size() - 1), 0.8 * energy(0)) << name;
    }
}

TEST(RelaxingRelease, IsElasticWithEndlessTimes) {
    const PulledRod rod({"endless", {0.5}, {std::numeric_limits<double>::infinity()}}, 1.0);
    auto elastic_problem = rod.problem;
    elastic_problem.load_case.slow_history.reset();
    const auto springs = rod.springs();
    const auto followed = msm::follow_history(springs, rod.problem, springs.node_mass);
    const auto conditions =
        msm::nodal_conditions({rod.problem.body, core::without_tractions(rod.problem.load_case)}, springs.node_mass);
    const auto &points = rod.problem.body->mesh.points;
    const auto plan = msm::plan_steps(rod.problem, msm::largest_angular_frequency(springs, points, conditions), {});
    const auto expected = msm::release(elastic_problem, springs, conditions, followed.end.displacement, plan);
    EXPECT_LT(error_of(rod.motion(springs), expected.displacement), 1e-6);
}

} // namespace
} // namespace livermark
