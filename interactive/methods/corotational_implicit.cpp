#include <memory>
#include <utility>
#include <vector>

#include "interactive/elements/element_energy.hpp"
#include "interactive/method.hpp"

namespace livermark::interactive::methods {

namespace {

using CorotationalEnergy = ElementEnergy<densities::Corotational>;

/// One linearised step of backward Euler by conjugate gradients: with R of each tetrahedron and its forces f where the
/// step begins, and K the stiffness of linear elasticity, turned by R,
///     (m (1 + alpha h) + h^2 K) v = m v_n + h (f + f_ext),   x = x_n + h v.
/// An iteration is one of conjugate gradients without a preconditioner, from v_n.
class CorotationalImplicit : public Simulation {
  public:
    explicit CorotationalImplicit(Scene given)
        : Simulation(std::move(given)), energy_(tetrahedra_at_rest(*scene().body)), rotations_(num_tetrahedra()),
          residual_(rest_positions(scene())), direction_(residual_), product_(residual_) {}

    void step(double time_step, int iterations) override {
        auto &x = mutable_positions();
        auto &v = mutable_velocities();
        product_.setZero();
        for (std::size_t t = 0; t < num_tetrahedra(); ++t) {
            const auto &tetrahedron = energy_.tetrahedra()[t];
            const Matrix3 gradient = tetrahedron.gradient(x);
            rotations_[t] = densities::rotation(gradient);
            const densities::Corotational density{tetrahedron.mu, tetrahedron.lambda};
            tetrahedron.add_forces(density.stress(gradient, rotations_[t]), product_);
        }
        residual_ = time_step * (product_ + external_forces());
        for (Eigen::Index i = 0; i < x.cols(); ++i)
            residual_.col(i) += scene().node_mass[i] * v.col(i);
        for (Eigen::Index c = 0; c < targets().cols(); ++c) {
            const int node = scene().constrained_nodes[c];
            v.col(node) = (targets().col(c) - x.col(node)) / time_step;
        }
        solve(v, time_step, iterations);
        x += time_step * v;
        move_to_targets(); // to the last bit
    }

    const Energy &energy() const override { return energy_; }

    Cost cost(int iterations) const override {
        return {.element_passes = 2.0 + iterations,
                .bytes_per_element = static_cast<double>(sizeof(Tetrahedron) + sizeof(Matrix3))};
    }

  private:
    std::size_t num_tetrahedra() const { return energy_.tetrahedra().size(); }

    /// A v, zero at constrained nodes.
    void multiply(const Field &v, double time_step, Field &product) const {
        product.setZero();
        for (std::size_t t = 0; t < num_tetrahedra(); ++t) { // K v, as forces of minus that
            const auto &tetrahedron = energy_.tetrahedra()[t];
            const Matrix3 rate = rotations_[t].transpose() * tetrahedron.gradient(v);
            Matrix3 stress = tetrahedron.mu * (rate + rate.transpose());
            stress.diagonal().array() += tetrahedron.lambda * rate.trace();
            tetrahedron.add_forces(rotations_[t] * stress, product);
        }
        product *= -time_step * time_step;
        const double damping = 1.0 + scene().mass_damping * time_step;
        for (Eigen::Index i = 0; i < v.cols(); ++i)
            product.col(i) += damping * scene().node_mass[i] * v.col(i);
        for (const int node : scene().constrained_nodes)
            product.col(node).setZero();
    }

    static constexpr double rounding = 1e-32; ///< of squares: there is nothing left to do

    /// Conjugate gradients for A v = residual, from v.
    void solve(Field &v, double time_step, int iterations) {
        multiply(v, time_step, product_);
        residual_ -= product_;
        for (const int node : scene().constrained_nodes)
            residual_.col(node).setZero();
        direction_ = residual_;
        const double first = residual_.squaredNorm();
        double squared = first;
        for (int i = 0; i < iterations && squared > rounding * first; ++i) {
            multiply(direction_, time_step, product_);
            const double length = squared / direction_.cwiseProduct(product_).sum();
            v += length * direction_;
            residual_ -= length * product_;
            const double next = residual_.squaredNorm();
            direction_ = residual_ + next / squared * direction_;
            squared = next;
        }
    }

    CorotationalEnergy energy_;
    std::vector<Matrix3> rotations_; ///< (M) where the step began
    Field residual_, direction_, product_;
};

} // namespace

/// SOFA's default for soft tissue.
Method corotational_implicit() {
    return {.name = {},
            .summary = "co-rotational linear tetrahedra, one linearised step of backward Euler by conjugate gradients",
            .source =
                "Mueller, Gross 2004, Interactive virtual materials, Graphics Interface; Baraff, Witkin 1998, Large "
                "steps in cloth simulation, SIGGRAPH; Faure et al. 2012, SOFA, Springer",
            .energy = "mu |F - R|^2 + lambda / 2 tr(R^T F - 1)^2",
            .converges_to = "the linearised step of backward Euler; at rest the equilibrium of the energy",
            .implementation = "plain loop over tetrahedra, matrix-free, double",
            .time_step = frame_time,
            .iterations = 25, // the default of SOFA's CGLinearSolver
            .prepare = [](const Scene &scene) { return std::make_unique<CorotationalImplicit>(scene); }};
}

} // namespace livermark::interactive::methods
