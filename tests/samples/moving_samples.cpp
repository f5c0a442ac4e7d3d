#include "tests/samples/moving_samples.hpp"

#include <cmath>
#include <limits>

#include "msm/dynamics/stepper.hpp"
#include "msm/integrator.hpp"
#include "msm/spring_law.hpp"
#include "msm/springs/springs.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::tests {

using core::Vector3;
using msm::State;

double random_value(std::mt19937 &random, double lowest, double highest) {
    return std::uniform_real_distribution<double>(lowest, highest)(random);
}

Vector3 random_vector(std::mt19937 &random, double largest) {
    return {random_value(random, -largest, largest), random_value(random, -largest, largest),
            random_value(random, -largest, largest)};
}

msm::NodalConditions free_conditions(std::size_t num_nodes) {
    msm::NodalConditions conditions;
    conditions.displacement.assign(num_nodes, Vector3::Constant(std::numeric_limits<double>::quiet_NaN()));
    conditions.constraint.assign(num_nodes, {-1, -1, -1});
    conditions.force.assign(num_nodes, Vector3::Zero());
    return conditions;
}

msm::NodalConditions some_conditions(std::size_t num_nodes, std::mt19937 &random) {
    auto conditions = free_conditions(num_nodes);
    for (std::size_t i = 0; i < num_nodes; ++i)
        if (i % 5 != 2)
            conditions.force[i] = random_vector(random, 0.01);
        else if (i % 2 == 0)
            conditions.displacement[i].setZero();
        else
            conditions.displacement[i].y() = 0.0;
    return conditions;
}

core::Body two_materials(int num_tetrahedra, double soft_ratio, double hard_ratio) {
    auto mesh = box_mesh({0.1, 0.1, 0.1}, {3, 3, 2});
    mesh.tetrahedra.resize(num_tetrahedra);
    mesh.region_names = {"soft", "hard"};
    mesh.region.assign(num_tetrahedra, 0);
    for (int t = 0; t < num_tetrahedra; ++t)
        mesh.region[t] = mesh.points[mesh.tetrahedra[t][0]].x() < 0.04 ? 0 : 1;
    return {.name = "two", .mesh = mesh, .materials = {{1060.0, 5e3, soft_ratio}, {1060.0, 2e4, hard_ratio}}};
}

core::Body lumpy_bar(const std::array<int, 3> &bricks, double hardness) {
    auto mesh = box_mesh({0.12, 0.04, 0.04}, bricks);
    mesh.region_names = {"soft", "hard"};
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
        Vector3 centre = Vector3::Zero();
        for (const int node : mesh.tetrahedra[t])
            centre += mesh.points[node] / 4.0;
        mesh.region[t] = centre.x() > 0.04 && centre.x() < 0.08 ? 1 : 0;
    }
    return {.name = "bar", .mesh = mesh, .materials = {{1060.0, 5e3, 0.45}, {1060.0, hardness * 5e3, 0.45}}};
}

Sample loose(const core::Body &body) {
    Sample sample;
    sample.positions = body.mesh.points;
    std::mt19937 random(static_cast<unsigned>(body.mesh.num_tetrahedra()));
    sample.conditions = some_conditions(sample.positions.size(), random);
    sample.body.node_mass.assign(sample.positions.size(), 0.002); // nodes of no tetrahedron would have none
    return sample;
}

Sample tetrahedra(int num_tetrahedra, const std::string &volume_term) {
    const auto body = two_materials(num_tetrahedra, 0.4, 0.45);
    auto sample = loose(body);
    sample.body.terms = msm::ElasticBody(msm::spring_network(body, msm::all_spring_laws().front())).terms;
    for (const auto &term : msm::all_volume_terms())
        if (term.name == volume_term)
            sample.body.terms.push_back(term.make(body, {7e3, 2e4}));
    sample.body.terms.push_back(msm::inversion_guard(body));
    return sample;
}

Sample coupled(const char *springs, int num_tetrahedra, double soft_ratio, double hard_ratio) {
    const auto body = two_materials(num_tetrahedra, soft_ratio, hard_ratio);
    auto sample = loose(body);
    sample.body.terms = msm::coupled_springs_with_volume(body, msm::find_coupled_springs(springs)).terms;
    return sample;
}

State shaken(const Sample &sample) {
    std::mt19937 random(5);
    const auto size = static_cast<Eigen::Index>(3 * sample.positions.size());
    State state{Eigen::VectorXd::Zero(size), Eigen::VectorXd::Zero(size)};
    for (std::size_t i = 0; i < sample.positions.size(); ++i)
        for (int c = 0; c < 3; ++c)
            if (std::isnan(sample.conditions.displacement[i][c])) {
                state.displacement[static_cast<Eigen::Index>(3 * i) + c] = random_value(random, -0.01, 0.01);
                state.velocity[static_cast<Eigen::Index>(3 * i) + c] = random_value(random, -0.5, 0.5);
            }
    return state;
}

State by_the_oracle(const Sample &sample, const core::RayleighDamping &damping, const msm::Integrator &integrator,
                    int num_steps) {
    const auto equation = msm::elastic_motion(sample.body, sample.positions, sample.conditions, damping);
    const auto take_step = integrator.prepare(equation, sample_step);
    auto state = shaken(sample);
    for (int s = 0; s < num_steps; ++s)
        take_step(state);
    return state;
}

State by_the_oracle(const Sample &sample, const core::RayleighDamping &damping, const std::string &integrator,
                    int num_steps) {
    return by_the_oracle(sample, damping, msm::find_integrator(integrator), num_steps);
}

State by_the_kernel(const Sample &sample, const core::RayleighDamping &damping, const std::string &integrator,
                    int num_steps, const msm::FastStepOptions &options) {
    auto steps = msm::FastSteps::prepare(sample.body, sample.positions, sample.conditions, damping, integrator,
                                         sample_step, options);
    EXPECT_TRUE(steps.has_value());
    steps->set_state(shaken(sample));
    steps->take(num_steps);
    return steps->state();
}

double error(const State &found, const State &expected, const Sample &sample) {
    const auto start = shaken(sample);
    const auto part = [](const Eigen::VectorXd &difference, const Eigen::VectorXd &change) {
        const double largest = difference.lpNorm<Eigen::Infinity>();
        return largest > 0.0 ? largest / change.lpNorm<Eigen::Infinity>() : 0.0;
    };
    return std::max(part(found.velocity - expected.velocity, expected.velocity - start.velocity),
                    part(found.displacement - expected.displacement, expected.displacement - start.displacement));
}

void expect_what_the_oracle_does(const Sample &sample) {
    for (const auto &damping : {core::RayleighDamping{0.0, 0.0}, core::RayleighDamping{3.0, 0.002}})
        for (const auto *integrator : {"symplectic_euler", "runge_kutta_chebyshev"}) {
            const auto expected = by_the_oracle(sample, damping, integrator, 3);
            for (const auto precision : both_precisions) {
                const auto found = by_the_kernel(sample, damping, integrator, 3, {.precision = precision});
                EXPECT_LT(error(found, expected, sample), tolerance(precision)) << integrator;
            }
        }
}

void expect_the_same_for_any_number_of_threads(const Sample &sample) {
    for (const auto precision : both_precisions)
        for (const auto *integrator : {"runge_kutta_4", "runge_kutta_chebyshev"}) {
            const auto one = by_the_kernel(sample, {3.0, 0.002}, integrator, 10, {precision, 1});
            for (const int num_threads : {2, 3, 7, 20}) {
                const auto many = by_the_kernel(sample, {3.0, 0.002}, integrator, 10, {precision, num_threads});
                EXPECT_EQ(one.displacement, many.displacement) << integrator << " " << num_threads;
                EXPECT_EQ(one.velocity, many.velocity) << integrator << " " << num_threads;
            }
        }
}

} // namespace livermark::tests
