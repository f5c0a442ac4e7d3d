#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <memory>

#include "benchmarks/harness.hpp"
#include "fem_reference/dynamics/modes.hpp"
#include "fem_reference/linear/elastic_system.hpp"
#include "msm/dynamics/time_step.hpp"
#include "tests/oracles/linear_elements.hpp"

namespace livermark::benchmarks::peers {

namespace {

/// Rotation of a deformation gradient, F = R S, by Newton's iteration R <- (R + R^-T) / 2 from R = F.
/// (Higham 1986, SIAM J. Sci. Stat. Comput. 7(4))
Eigen::Matrix3d rotation(const Eigen::Matrix3d &gradient) {
    constexpr double tolerance =
        1e-16; // of the square of what an iteration changes, and the next one changes its square
    constexpr int max_iterations = 20;
    Eigen::Matrix3d r = gradient;
    for (int i = 0; i < max_iterations; ++i) {
        const Eigen::Matrix3d next = 0.5 * (r + r.inverse().transpose());
        const double change = (next - r).squaredNorm();
        r = next;
        if (change < tolerance)
            break;
    }
    return r;
}

/// Linear tetrahedra whose stiffness turns with them (stiffness warping): f = -R K (R^T x - x_0) with R the rotation of
/// each, here as P = R (2 mu eps + lambda tr eps), eps = (R^T F + F^T R) / 2 - 1, which is the same.
/// (Mueller, Gross 2004, Interactive virtual materials, Graphics Interface)
class Corotational {
  public:
    Corotational(const Scene &scene, double time_step)
        : inverse_mass_(scene.start.size()), x_(3, scene.start.size()), v_(Eigen::Matrix3Xd::Zero(3, x_.cols())),
          f_(3, x_.cols()), h_(time_step) {
        const auto &body = *scene.problem.body;
        for (Eigen::Index i = 0; i < x_.cols(); ++i) {
            x_.col(i) = scene.start[i];
            inverse_mass_[i] = scene.is_constrained[i] ? 0.0 : 1.0 / scene.springs.node_mass[i];
        }
        for (int t = 0; t < body.mesh.num_tetrahedra(); ++t) {
            const auto &nodes = body.mesh.tetrahedra[t];
            const auto material = body.material_of(t);
            Eigen::Matrix3d edges;
            for (int c = 0; c < 3; ++c)
                edges.col(c) = body.mesh.points[nodes[c + 1]] - body.mesh.points[nodes[0]];
            const double volume = edges.determinant() / 6.0;
            elements_.push_back({.nodes = nodes,
                                 .inverse_edges = edges.inverse(),
                                 .two_mu_volume = 2.0 * material.shear_modulus() * volume,
                                 .lambda_volume = material.lame_lambda() * volume});
        }
    }

    /// Elastic forces of nodes at x.
    void compute_forces(const Eigen::Matrix3Xd &x, Eigen::Matrix3Xd &f) const {
        f.setZero();
        for (const auto &element : elements_) {
            const auto &[a, b, c, d] = element.nodes;
            Eigen::Matrix3d edges;
            edges << x.col(b) - x.col(a), x.col(c) - x.col(a), x.col(d) - x.col(a);
            const Eigen::Matrix3d gradient = edges * element.inverse_edges;
            const Eigen::Matrix3d r = rotation(gradient);
            const Eigen::Matrix3d turned = r.transpose() * gradient;
            const Eigen::Matrix3d strain = 0.5 * (turned + turned.transpose()) - Eigen::Matrix3d::Identity();
            Eigen::Matrix3d stress = element.two_mu_volume * strain;
            stress.diagonal().array() += element.lambda_volume * strain.trace();
            const Eigen::Matrix3d forces = -r * stress * element.inverse_edges.transpose();
            f.col(a) -= forces.rowwise().sum();
            f.col(b) += forces.col(0);
            f.col(c) += forces.col(1);
            f.col(d) += forces.col(2);
        }
    }

    /// Symplectic Euler.
    void step() {
        compute_forces(x_, f_);
        v_ += h_ * f_ * inverse_mass_.asDiagonal();
        x_ += h_ * v_;
    }

    const Eigen::Matrix3Xd &positions() const { return x_; }
    const Eigen::VectorXd &inverse_mass() const { return inverse_mass_; }

  private:
    struct Element {
        std::array<int, 4> nodes;
        Eigen::Matrix3d inverse_edges; ///< of the edges from the first corner, at rest
        double two_mu_volume, lambda_volume;
    };

    std::vector<Element> elements_;
    Eigen::VectorXd inverse_mass_; ///< zero where constrained
    Eigen::Matrix3Xd x_, v_, f_;
    double h_;
};

std::vector<core::Vector3> to_field(const Eigen::Matrix3Xd &x) {
    return {x.colwise().begin(), x.colwise().end()};
}

Run make(const Scene &scene, double time_step) {
    auto body = std::make_shared<Corotational>(scene, time_step);
    return {.step = [body] { body->step(); }, .positions = [body] { return to_field(body->positions()); }};
}

double critical_step(const Scene &scene) {
    const auto &body = *scene.problem.body;
    const double highest = msm::largest_angular_frequency(
        msm::ElasticBody(scene.springs.node_mass, {tests::linear_elements(body)}), body.mesh.points, scene.conditions);
    return msm::critical_time_step(msm::find_integrator("symplectic_euler"), {}, highest, highest);
}

/// Forces of small strains on a body that is turned by a radian are -K u of linear elements, turned: what is neglected
/// is as large as the strains.
std::string differs_from_linear_elements(const Scene &scene, const Corotational &elements) {
    constexpr double strain = 1e-7, tolerance = 1e-5;
    const auto &body = *scene.problem.body;
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(1.0, Eigen::Vector3d(1.0, 2.0, 3.0).normalized()).matrix();
    Eigen::Matrix3Xd x(3, elements.positions().cols()), u(x), f(x), linear(x);
    for (Eigen::Index i = 0; i < x.cols(); ++i) {
        const auto &at = body.mesh.points[i];
        // Not affine, with every component of strain in it.
        u.col(i) = strain * Eigen::Vector3d(at.x() - 3.0 * at.y(), std::sin(30.0 * at.z()) / 30.0, at.x() + at.y());
        x.col(i) = turn * (at + u.col(i));
    }
    elements.compute_forces(x, f);
    const auto system = fem_reference::assemble(body, 1);
    system.stiffness.multiply({u.data(), static_cast<std::size_t>(u.size())},
                              {linear.data(), static_cast<std::size_t>(linear.size())});
    const double error = (f + turn * linear).norm() / linear.norm();
    if (error < tolerance)
        return {};
    return fmt::format("forces of small strains are {:.3g} away from those of linear elements, and {:.3g} is allowed",
                       error, tolerance);
}

std::string check(const Scene &scene, double time_step, Run &run) {
    const Corotational elements(scene, time_step);
    if (auto fault = differs_from_linear_elements(scene, elements); !fault.empty())
        return fault;
    const auto &start = elements.positions();
    Eigen::Matrix3Xd f(start);
    elements.compute_forces(start, f);
    run.step();
    return differs_from(to_field(start + time_step * time_step * f * elements.inverse_mass().asDiagonal()), scene, run,
                        1e-9);
}

} // namespace

Competitor fem_corotational() {
    Method method;
    method.integrator = "symplectic_euler";
    method.critical_time_step = critical_step;
    method.make = make;
    method.check = check;
    return {.summary =
                "linear tetrahedra whose stiffness turns with them, explicit, masses of the springs; a plain loop",
            .source = "Mueller, Gross 2004, Interactive virtual materials, Graphics Interface",
            .methods = {method}};
}

} // namespace livermark::benchmarks::peers
