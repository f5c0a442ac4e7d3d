#include <Eigen/Geometry>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "msm/spring_network.hpp"
#include "tests/test_meshes.hpp"

namespace livermark {
namespace {

using core::Vector3;

struct Springs {
    std::shared_ptr<const core::Body> body;
    core::SpringNetwork network;
};

Springs box_of_springs() {
    auto body = tests::make_body(tests::box_mesh({0.1, 0.1, 0.1}, {3, 3, 3}), {1060.0, 5e3, 0.25});
    auto network = msm::spring_network(*body, msm::all_spring_laws().front());
    return {std::move(body), std::move(network)};
}

std::vector<Vector3> shaken(std::vector<Vector3> positions, double size) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> offset(-size, size);
    for (auto &x : positions)
        x += Vector3(offset(random), offset(random), offset(random));
    return positions;
}

TEST(SpringNetwork, RigidMotionsCostNoEnergy) {
    const auto [body, network] = box_of_springs();
    const Eigen::AngleAxisd turn(1.1, Vector3(1.0, 2.0, -0.5).normalized());
    auto moved = body->mesh.points;
    for (auto &x : moved)
        x = turn * x + Vector3(0.3, -0.2, 0.7);
    const double stretched = msm::elastic_energy(network, shaken(body->mesh.points, 1e-3));
    EXPECT_LT(msm::elastic_energy(network, moved), 1e-24 * stretched + 1e-28);
    for (const auto &force : msm::elastic_gradient(network, moved))
        EXPECT_LT(force.norm(), 1e-13);
}

TEST(SpringNetwork, GradientIsTheDerivativeOfTheEnergy) {
    const auto [body, network] = box_of_springs();
    const auto positions = shaken(body->mesh.points, 5e-3);
    const auto gradient = msm::elastic_gradient(network, positions);
    const double step = 1e-6;
    for (const std::size_t node : {std::size_t{0}, std::size_t{21}, positions.size() - 1})
        for (int c = 0; c < 3; ++c) {
            auto forward = positions;
            auto backward = positions;
            forward[node][c] += step;
            backward[node][c] -= step;
            const double slope =
                (msm::elastic_energy(network, forward) - msm::elastic_energy(network, backward)) / (2.0 * step);
            EXPECT_NEAR(gradient[node][c], slope, 1e-6);
        }
}

TEST(SpringNetwork, HessianIsTheDerivativeOfTheGradient) {
    const auto [body, network] = box_of_springs();
    const auto positions = shaken(body->mesh.points, 5e-3);
    const auto hessian = msm::elastic_hessian(network, positions, msm::Tangent::exact);
    const double step = 1e-7;
    const int node = 21;
    for (int c = 0; c < 3; ++c) {
        auto forward = positions;
        auto backward = positions;
        forward[node][c] += step;
        backward[node][c] -= step;
        const auto after = msm::elastic_gradient(network, forward);
        const auto before = msm::elastic_gradient(network, backward);
        for (std::size_t i = 0; i < positions.size(); ++i)
            for (int d = 0; d < 3; ++d)
                EXPECT_NEAR(hessian.coeff(static_cast<Eigen::Index>(3 * i) + d, 3 * node + c),
                            (after[i][d] - before[i][d]) / (2.0 * step), 1e-5);
    }
}

TEST(SpringNetwork, InternalForcesHaveNoResultantAndNoMoment) {
    const auto [body, network] = box_of_springs();
    const auto positions = shaken(body->mesh.points, 5e-3);
    Vector3 force = Vector3::Zero();
    Vector3 moment = Vector3::Zero();
    double scale = 0.0;
    const auto gradient = msm::elastic_gradient(network, positions);
    for (std::size_t i = 0; i < positions.size(); ++i) {
        force += gradient[i];
        moment += positions[i].cross(gradient[i]);
        scale += gradient[i].norm();
    }
    EXPECT_LT(force.norm(), 1e-14 * scale);
    EXPECT_LT(moment.norm(), 1e-14 * scale);
}

} // namespace
} // namespace livermark
