#include "interactive/elements/explicit_tetrahedra.hpp"

#include <Eigen/Eigenvalues>
#include <Spectra/SymEigsSolver.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "core/mesh/tetra_mesh.hpp"
#include "interactive/elements/energies.hpp"
#include "interactive/kernels/explicit_steps.hpp"

namespace livermark::interactive {

namespace {

/// M^-1/2 K M^-1/2 over the free components, for Spectra.
class ScaledStiffness {
  public:
    using Scalar = double;

    ScaledStiffness(const Energy &energy, const Scene &scene) : energy_(&energy), rest_(rest_positions(scene)) {
        const auto is_free = free_nodes(scene);
        for (Eigen::Index i = 0; i < rest_.cols(); ++i)
            if (is_free[i]) {
                nodes_.push_back(i);
                root_.push_back(1.0 / std::sqrt(scene.node_mass[i]));
            }
        // As small against an element as leaves half of the digits.
        constexpr double part_of_body = 1e-7;
        length_ = part_of_body * core::extent(scene.body->mesh.points);
    }

    Eigen::Index rows() const { return 3 * static_cast<Eigen::Index>(nodes_.size()); }
    Eigen::Index cols() const { return rows(); }

    void perform_op(const double *in, double *out) const {
        Field move = Field::Zero(3, rest_.cols());
        for (std::size_t k = 0; k < nodes_.size(); ++k)
            move.col(nodes_[k]) = root_[k] * core::Vector3(in[3 * k], in[3 * k + 1], in[3 * k + 2]);
        const double largest = move.cwiseAbs().maxCoeff();
        const double factor = largest > 0.0 ? length_ / largest : 1.0;
        Field behind = Field::Zero(3, rest_.cols()), ahead = behind;
        energy_->add_forces(rest_ - factor * move, behind);
        energy_->add_forces(rest_ + factor * move, ahead);
        for (std::size_t k = 0; k < nodes_.size(); ++k)
            Eigen::Map<core::Vector3>(out + 3 * k) =
                root_[k] / (2.0 * factor) * (behind.col(nodes_[k]) - ahead.col(nodes_[k]));
    }

  private:
    const Energy *energy_;
    Field rest_;
    std::vector<Eigen::Index> nodes_; ///< that are free
    std::vector<double> root_;        ///< of one over their masses
    double length_ = 0.0;             ///< of the differences [m]
};

} // namespace

double critical_time_step(const Energy &energy, const Scene &scene) {
    ScaledStiffness operation(energy, scene);
    if (operation.rows() == 0)
        return std::numeric_limits<double>::infinity();
    constexpr Eigen::Index num_vectors = 24;
    constexpr int most_restarts = 200;
    constexpr double tolerance = 1e-4;
    Spectra::SymEigsSolver<ScaledStiffness> solver(operation, 1, std::min(num_vectors, operation.rows()));
    solver.init();
    if (solver.compute(Spectra::SortRule::LargestAlge, most_restarts, tolerance) < 1)
        throw std::runtime_error("the highest frequency of the body is not found");
    return 2.0 / std::sqrt(solver.eigenvalues()[0]);
}

double critical_time_step_bound(const std::vector<Tetrahedron> &tetrahedra, const std::vector<double> &node_mass) {
    std::vector<double> node_volume(node_mass.size(), 0.0);
    for (const auto &t : tetrahedra)
        for (const int node : t.nodes)
            node_volume[node] += t.volume;
    double highest = 0.0;
    for (const auto &t : tetrahedra) {
        const auto gradients = t.shape_gradients();
        Eigen::Matrix<double, 12, 9> strain; // dF of unit moves, over the roots of masses
        for (int a = 0; a < 4; ++a) {
            const double mass = node_mass[t.nodes[a]] * t.volume / node_volume[t.nodes[a]];
            for (int j = 0; j < 3; ++j)
                strain.block<3, 3>(3 * a, 3 * j) = gradients(a, j) / std::sqrt(mass) * Matrix3::Identity();
        }
        const densities::Tangent tangent = densities::NeoHookean{t.mu, t.lambda}.tangent(Matrix3::Identity());
        const Eigen::Matrix<double, 12, 12> matrix = t.volume * strain * tangent * strain.transpose();
        highest = std::max(highest,
                           Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 12, 12>>(matrix, Eigen::EigenvaluesOnly)
                               .eigenvalues()
                               .maxCoeff());
    }
    return 2.0 / std::sqrt(highest);
}

namespace {

/// The nodes of a step as rows keep them.
class NodesInRows : public core::MovingNodes {
  public:
    /// @param time_step  h of the step [s]
    NodesInRows(kernels::ExplicitRows &rows, double time_step) : rows_(rows), time_step_(time_step) {}

    void displacements(std::span<const int> nodes, std::span<core::Vector3> found) const override {
        for (std::size_t i = 0; i < nodes.size(); ++i)
            found[i] = in_row(std::as_const(rows_.displacement), rows_.row_of_node[nodes[i]]).cast<double>();
    }
    void kick(std::span<const int> nodes, std::span<const core::Vector3> velocity, double /*h*/) override {
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            in_row(rows_.displacement, rows_.row_of_node[nodes[i]]) += (time_step_ * velocity[i]).cast<float>();
            in_row(rows_.velocity, rows_.row_of_node[nodes[i]]) += velocity[i].cast<float>();
        }
    }

  private:
    kernels::ExplicitRows &rows_;
    double time_step_;
};

} // namespace

ExplicitTetrahedra::ExplicitTetrahedra(Scene given, kernels::Pressure pressure)
    : SimulationInRows(std::move(given)), pressure_(pressure), rows_(kernels::explicit_rows(scene(), pressure_)) {}

void ExplicitTetrahedra::step(double time_step, int iterations) {
    rows_.aim_constrained(scene(), rest_, positions(), targets(), time_step);
    const double h = time_step / iterations;
    if (!correction_ && !ball_ && !after_step_)
        kernels::take_explicit_steps(rows_, h, scene().mass_damping, iterations);
    else
        for (int i = 0; i < iterations; ++i) {
            if (correction_)
                take_corrected_step(h);
            else
                kernels::take_explicit_steps(rows_, h, scene().mass_damping, 1);
            if (ball_)
                push_out(ball_->part(i, iterations), h);
            if (after_step_) {
                NodesInRows nodes(rows_, h);
                after_step_(nodes, static_cast<double>(i + 1) / iterations, h);
            }
        }
    take_state_from_rows();
}

double ExplicitTetrahedra::critical_time_step() const {
    if (!critical_time_step_)
        critical_time_step_ = interactive::critical_time_step(energy(), scene());
    return *critical_time_step_;
}

bool ExplicitTetrahedra::correct_steps(const std::shared_ptr<StepCorrection> &correction) {
    correction_ = correction;
    return true;
}

bool ExplicitTetrahedra::act_after_steps(const AfterStep &action) {
    after_step_ = action;
    return true;
}

Cost ExplicitTetrahedra::cost(int iterations) const {
    return cost_of((pressure_ == kernels::Pressure::around_nodes ? 2.0 : 1.0) * iterations, rows_.bytes());
}

/// After a step of length h.
void ExplicitTetrahedra::push_out(const core::BallStep &step, double h) {
    const auto position = [&](int n) { return row_position(n); };
    const auto velocity = [&](int n) { return FineRow(core::Vector3::Zero(), in_row(rows_.velocity, row_of(n))); };
    const double per_mass = h * h / (1.0 + 0.5 * scene().mass_damping * h);
    const auto yields = [&](int n) { return is_free()[n] ? per_mass / scene().node_mass[n] : 0.0; };
    const auto give = [&](int n, const core::Vector3 &force) {
        const core::Vector3 way = yields(n) * force;
        position(n) += way;
        velocity(n) += way / h;
    };
    ball_->begin_step(give);
    ball_->sweep(
        step, [&](int n) { return core::Vector3(core::Vector3(position(n)) - h * core::Vector3(velocity(n))); },
        position, [&](int n) { return Matrix3(yields(n) * Matrix3::Identity()); }, give);
    ball_->end_step(h);
}

/// Steps of (1 + alpha h / 2) v = (1 - alpha h / 2) v_before + change, and of the change that is corrected.
void ExplicitTetrahedra::take_corrected_step(double h) {
    const auto &nodes = correction_->nodes();
    const auto num_nodes = static_cast<Eigen::Index>(nodes.size());
    const double half_damping = 0.5 * scene().mass_damping * h;
    const auto row = [&](kernels::Aligned<float> &field, Eigen::Index i) { return in_row(field, row_of(nodes[i])); };
    Field x(3, num_nodes), before = x, change = x;
    for (Eigen::Index i = 0; i < num_nodes; ++i) {
        x.col(i) = rest_.col(nodes[i]) + row(rows_.displacement, i).cast<double>();
        before.col(i) = row(rows_.velocity, i).cast<double>();
    }
    kernels::take_explicit_steps(rows_, h, scene().mass_damping, 1);
    for (Eigen::Index i = 0; i < num_nodes; ++i)
        change.col(i) =
            (1.0 + half_damping) * row(rows_.velocity, i).cast<double>() - (1.0 - half_damping) * before.col(i);
    const Field uncorrected = change;
    correction_->correct(x, before, h, change);
    for (Eigen::Index i = 0; i < num_nodes; ++i) {
        const Eigen::Vector3f more = ((change.col(i) - uncorrected.col(i)) / (1.0 + half_damping)).cast<float>();
        row(rows_.velocity, i) += more;
        row(rows_.displacement, i) += static_cast<float>(h) * more;
    }
}

} // namespace livermark::interactive
