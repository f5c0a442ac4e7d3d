#include <Eigen/Core>
#include <memory>

#include "benchmarks/harness.hpp"

namespace livermark::benchmarks::peers {

namespace {

/// The code that a competent user writes first: a loop over springs that adds to the forces at both ends.
struct Springs {
    explicit Springs(const Scene &scene)
        : springs(scene.springs), inverse_mass(scene.start.size()), x(3, scene.start.size()),
          v(Eigen::Matrix3Xd::Zero(3, x.cols())), f(3, x.cols()) {
        for (Eigen::Index i = 0; i < x.cols(); ++i) {
            x.col(i) = scene.start[i];
            inverse_mass[i] = scene.is_constrained[i] ? 0.0 : 1.0 / scene.springs.node_mass[i];
        }
    }

    void compute_acceleration(const Eigen::Matrix3Xd &at, Eigen::Matrix3Xd &a) const {
        a.setZero();
        for (std::size_t s = 0; s < springs.edges.size(); ++s) {
            const auto [i, j] = springs.edges[s];
            const Eigen::Vector3d span = at.col(j) - at.col(i);
            const double length = span.norm();
            const Eigen::Vector3d force = springs.stiffness[s] * (length - springs.rest_length[s]) / length * span;
            a.col(i) += force;
            a.col(j) -= force;
        }
        a *= inverse_mass.asDiagonal();
    }

    void step_symplectic_euler(double h) {
        compute_acceleration(x, f);
        v += h * f;
        x += h * v;
    }

    void step_runge_kutta_4(double h) {
        compute_acceleration(x, f);
        x2 = x + 0.5 * h * v;
        v2 = v + 0.5 * h * f;
        compute_acceleration(x2, f2);
        x3 = x + 0.5 * h * v2;
        v3 = v + 0.5 * h * f2;
        compute_acceleration(x3, f3);
        x4 = x + h * v3;
        v4 = v + h * f3;
        compute_acceleration(x4, f4);
        x += h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4);
        v += h / 6.0 * (f + 2.0 * f2 + 2.0 * f3 + f4);
    }

    core::SpringNetwork springs;
    Eigen::VectorXd inverse_mass;
    Eigen::Matrix3Xd x, v, f;
    Eigen::Matrix3Xd x2 = x, v2 = v, f2 = f, x3 = x, v3 = v, f3 = f, x4 = x, v4 = v, f4 = f;
};

using Step = void (Springs::*)(double);

template <Step step> Run make(const Scene &scene, double h) {
    auto springs = std::make_shared<Springs>(scene);
    return {
        .step = [springs, h] { ((*springs).*step)(h); },
        .positions =
            [springs] { return std::vector<core::Vector3>(springs->x.colwise().begin(), springs->x.colwise().end()); }};
}

/// Nothing but the order of operations sets it apart: 1e-13 to 8e-13 were seen.
constexpr double tolerance = 1e-11;

} // namespace

Competitor eigen_loop() {
    return {.summary = "a plain loop over springs with Eigen, double precision",
            .source = "what a competent user writes first",
            .methods = {
                spring_method("runge_kutta_4", make<&Springs::step_runge_kutta_4>, tolerance),
                spring_method("symplectic_euler", make<&Springs::step_symplectic_euler>, tolerance),
            }};
}

} // namespace livermark::benchmarks::peers
