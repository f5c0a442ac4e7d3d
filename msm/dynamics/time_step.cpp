#include "msm/dynamics/time_step.hpp"

#include <Eigen/Dense>
#include <Eigen/Eigenvalues>
#include <Spectra/SymEigsSolver.h>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "core/support/input_error.hpp"

namespace livermark::msm {

FreeComponents::FreeComponents(const Field &prescribed) {
    number_.reserve(3 * prescribed.size());
    for (const auto &node : prescribed)
        for (int component = 0; component < 3; ++component)
            number_.push_back(std::isnan(node[component]) ? size_++ : -1);
}

std::vector<bool> FreeComponents::are_free() const {
    std::vector<bool> free;
    free.reserve(number_.size());
    for (const auto number : number_)
        free.push_back(number >= 0);
    return free;
}

Eigen::VectorXd FreeComponents::gather(const Field &field) const {
    Eigen::VectorXd values(size_);
    for (std::size_t c = 0; c < number_.size(); ++c)
        if (number_[c] >= 0)
            values[number_[c]] = field[c / 3][static_cast<Eigen::Index>(c % 3)];
    return values;
}

void FreeComponents::add(Field &field, const Eigen::VectorXd &values, double scale) const {
    for (std::size_t c = 0; c < number_.size(); ++c)
        if (number_[c] >= 0)
            field[c / 3][static_cast<Eigen::Index>(c % 3)] += scale * values[number_[c]];
}

Eigen::SparseMatrix<double> FreeComponents::restrict(const Eigen::SparseMatrix<double> &matrix) const {
    // Free components are in the order of all, so entries come as a compressed matrix keeps them.
    Eigen::SparseMatrix<double> restricted(size_, size_);
    restricted.reserve(matrix.nonZeros());
    for (Eigen::Index column = 0; column < matrix.outerSize(); ++column) {
        if (!is_free(column))
            continue;
        restricted.startVec(number_[column]);
        for (Eigen::SparseMatrix<double>::InnerIterator entry(matrix, column); entry; ++entry)
            if (is_free(entry.row()))
                restricted.insertBackByOuterInner(number_[column], number_[entry.row()]) = entry.value();
    }
    restricted.finalize();
    return restricted;
}

Eigen::VectorXd inverse_root_mass(const std::vector<double> &node_mass, const FreeComponents &free) {
    Field root;
    root.reserve(node_mass.size());
    for (const double mass : node_mass)
        root.emplace_back(core::Vector3::Constant(1.0 / std::sqrt(mass)));
    return free.gather(root);
}

namespace {

/// omega, and M^1/2 phi of the free components, of length 1.
using Pair = std::pair<double, Eigen::VectorXd>;

/// Tolerance of the largest omega^2: its residual bounds the error of an eigenvalue.
constexpr double largest_tolerance = 1e-9;
constexpr int most_restarts = 1000;
constexpr Eigen::Index num_vectors_for_largest = 40;

/// y = M^-1/2 K M^-1/2 x, term by term, as Spectra asks for it.
class ScaledStiffness {
  public:
    using Scalar = double;
    ScaledStiffness(const ElasticBody &body, const Field &positions, const FreeComponents &free,
                    const MassScaling &scaling)
        : stiffness_(body, positions), free_(free), num_nodes_(positions.size()), node_mass_(body.node_mass),
          inverse_root_mass_(inverse_root_mass(body.node_mass, free)), scaling_(scaling),
          rest_(to_unknowns(positions)) {}

    Eigen::Index rows() const { return free_.size(); }
    Eigen::Index cols() const { return free_.size(); }
    void perform_op(const double *x, double *y) const {
        displacement_.assign(num_nodes_, core::Vector3::Zero());
        free_.add(displacement_, Eigen::VectorXd::Map(x, rows()).cwiseProduct(inverse_root_mass_), 1.0);
        Eigen::VectorXd moved = to_unknowns(displacement_);
        scale_deformation(scaling_, -0.5, rest_, moved);
        Eigen::VectorXd force = stiffness_.times(moved);
        // M^1/2 (Q + (I - Q) f^-1/2) M^-1, the transpose of what made the displacement
        scale_by_mass(force, -1.0);
        scale_deformation(scaling_, -0.5, rest_, force);
        scale_by_mass(force, 1.0);
        Eigen::VectorXd::Map(y, rows()) = free_.gather(to_field(force)).cwiseProduct(inverse_root_mass_);
    }

  private:
    void scale_by_mass(Eigen::VectorXd &field, double power) const {
        if (!scaling_.parts.empty())
            for (std::size_t i = 0; i < num_nodes_; ++i)
                node_part(field, static_cast<int>(i)) *= std::pow(node_mass_[i], power);
    }

    StiffnessProduct stiffness_;
    const FreeComponents &free_;
    std::size_t num_nodes_;
    const std::vector<double> &node_mass_;
    Eigen::VectorXd inverse_root_mass_;
    MassScaling scaling_;
    Eigen::VectorXd rest_;
    mutable Field displacement_;
};

/// Lanczos's method has no room in fewer unknowns than it keeps vectors, but there the matrix can be written down.
Pair highest_of_few(const ScaledStiffness &stiffness) {
    Eigen::MatrixXd matrix(stiffness.rows(), stiffness.cols());
    const Eigen::MatrixXd unit = Eigen::MatrixXd::Identity(matrix.rows(), matrix.cols());
    for (Eigen::Index c = 0; c < matrix.cols(); ++c)
        stiffness.perform_op(unit.col(c).data(), matrix.col(c).data());
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(matrix); // ascending
    return {std::sqrt(std::max(0.0, solver.eigenvalues()[matrix.rows() - 1])),
            solver.eigenvectors().col(matrix.rows() - 1)};
}

Pair highest_pair(const ElasticBody &body, const Field &positions, const FreeComponents &free,
                  const MassScaling &scaling = {}, double tolerance = largest_tolerance) {
    if (free.size() == 0)
        return {};
    ScaledStiffness stiffness(body, positions, free, scaling);
    if (free.size() <= num_vectors_for_largest)
        return highest_of_few(stiffness);
    // Three are asked for, so that a near copy of the largest is told from it and does not slow it down.
    Spectra::SymEigsSolver<ScaledStiffness> lanczos(stiffness, 3, num_vectors_for_largest);
    lanczos.init(); // from a random vector of fixed seed
    lanczos.compute(Spectra::SortRule::LargestAlge, most_restarts, tolerance, Spectra::SortRule::LargestAlge);
    if (lanczos.info() != Spectra::CompInfo::Successful)
        throw std::runtime_error(
            fmt::format("the largest frequency did not converge in {} restarts of Lanczos's method", most_restarts));
    return {std::sqrt(lanczos.eigenvalues()[0]), lanczos.eigenvectors(1)};
}

} // namespace

HighestMode highest_mode(const ElasticBody &body, const Field &positions, const NodalConditions &conditions) {
    HighestMode mode;
    mode.free = FreeComponents(conditions.displacement);
    const auto [frequency, shape] = highest_pair(body, positions, mode.free);
    mode.angular_frequency = frequency;
    Field field(positions.size(), core::Vector3::Zero());
    mode.free.add(field, shape, 1.0);
    mode.shape = to_unknowns(field);
    return mode;
}

double largest_angular_frequency(const ElasticBody &body, const Field &positions, const NodalConditions &conditions,
                                 const MassScaling &scaling, double tolerance) {
    return highest_pair(body, positions, FreeComponents(conditions.displacement), scaling, tolerance).first;
}

double largest_angular_frequency(const ElasticBody &body, const Field &positions, const NodalConditions &conditions,
                                 const HighestMode &less) {
    const FreeComponents free(conditions.displacement);
    const auto is_free = free.are_free(), was_free = less.free.are_free();
    const bool constrains_more = std::ranges::equal(is_free, was_free, [](bool is, bool was) { return was || !is; });
    const Eigen::VectorXd trial = free.gather(to_field(less.shape));
    Eigen::VectorXd image(free.size());
    if (constrains_more && trial.squaredNorm() > 0.0) {
        ScaledStiffness(body, positions, free, {}).perform_op(trial.data(), image.data());
        const double above = less.angular_frequency * less.angular_frequency;
        const double below = trial.dot(image) / trial.squaredNorm();
        if (above - below <= largest_tolerance * above)
            return less.angular_frequency;
    }
    return largest_angular_frequency(body, positions, conditions);
}

std::vector<double> nodal_frequency_bounds(const ElasticBody &body, const Field &positions,
                                           const NodalConditions &conditions) {
    std::vector<Eigen::Matrix3d> block(body.node_mass.size(), Eigen::Matrix3d::Zero());
    for (const auto &term : body.terms)
        term->add_block_bound(to_unknowns(positions), block);
    std::vector<double> bounds;
    for (std::size_t i = 0; i < block.size(); ++i) {
        for (int c = 0; c < 3; ++c)
            if (!std::isnan(conditions.displacement[i][c])) {
                block[i].row(c).setZero();
                block[i].col(c).setZero();
            }
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(block[i], Eigen::EigenvaluesOnly);
        bounds.push_back(std::sqrt(std::max(0.0, eigen.eigenvalues()[2] / body.node_mass[i])));
    }
    return bounds;
}

double gershgorin_angular_frequency(const ElasticBody &body, const Field &positions,
                                    const NodalConditions &conditions) {
    const auto bounds = nodal_frequency_bounds(body, positions, conditions);
    return bounds.empty() ? 0.0 : *std::ranges::max_element(bounds);
}

namespace {

/// Growth that is put down to rounding.
constexpr double rounding = 1e-12;
constexpr int num_frequencies = 48;
/// Steps are tried from this part of the shortest time scale on. Without damping the growth of an integrator that is
/// never stable would at much smaller steps be lost in rounding; those that are stable are so up to 2 and more. What
/// does not bear it with damping, as explicit Euler where that is weak, begins much lower.
constexpr double usual_first_try = 0.3;
constexpr double smallest_damped_try = 1e-5;
constexpr double largest_try = 1e3;
/// From one try to the next; finer than any gap in what the integrators can bear.
constexpr double ratio = 1.02;
constexpr int num_bisections = 40;

/// Takes (omega u, v) from one time to the next.
Eigen::Matrix2d propagator(const Integrator &integrator, double omega, double damping_ratio, double time_step) {
    EquationOfMotion equation;
    equation.mass = Eigen::VectorXd::Ones(1);
    equation.acceleration = [=](const Eigen::VectorXd &u, const Eigen::VectorXd &v, Eigen::VectorXd &a) {
        a = -omega * omega * u - 2.0 * damping_ratio * omega * v;
    };
    equation.effective_mass = [=](const Eigen::VectorXd &, double d, double k) {
        Eigen::SparseMatrix<double> matrix(1, 1);
        matrix.insert(0, 0) = 1.0 + d * 2.0 * damping_ratio * omega + k * omega * omega;
        return matrix;
    };
    const auto step = integrator.prepare(equation, time_step);
    Eigen::Matrix2d matrix;
    for (int column = 0; column < 2; ++column) {
        State state{Eigen::VectorXd::Zero(1), Eigen::VectorXd::Zero(1)};
        (column == 0 ? state.displacement[0] : state.velocity[0]) = column == 0 ? 1.0 / omega : 1.0;
        step(state);
        matrix.col(column) << omega * state.displacement[0], state.velocity[0];
    }
    return matrix;
}

double spectral_radius(const Eigen::Matrix2d &matrix) {
    const double half_trace = 0.5 * matrix.trace();
    const double discriminant = half_trace * half_trace - matrix.determinant();
    return discriminant < 0.0 ? std::sqrt(matrix.determinant()) : std::abs(half_trace) + std::sqrt(discriminant);
}

} // namespace

bool is_stable(const Integrator &integrator, double omega, double damping_ratio, double time_step) {
    const auto matrix = propagator(integrator, omega, damping_ratio, time_step);
    // Jury's conditions on z^2 - trace z + det. The eigenvalues themselves lose half the digits where the two meet,
    // which a critically damped oscillation makes them do at every small step.
    const double determinant = matrix.determinant();
    return determinant <= 1.0 + rounding && std::abs(matrix.trace()) <= 1.0 + determinant + rounding;
}

double largest_amplification(const Integrator &integrator, const core::RayleighDamping &damping, double lowest,
                             double highest, double time_step) {
    double largest = 0.0;
    for (int f = 0; f < num_frequencies; ++f) {
        const double omega = highest * std::pow(lowest / highest, f / (num_frequencies - 1.0));
        largest = std::max(largest, spectral_radius(propagator(integrator, omega, damping.ratio(omega), time_step)));
    }
    return largest;
}

double critical_time_step(const Integrator &integrator, const core::RayleighDamping &damping, double lowest,
                          double highest) {
    std::vector<double> frequencies;
    for (int f = 0; f < num_frequencies; ++f)
        frequencies.push_back(highest * std::pow(lowest / highest, f / (num_frequencies - 1.0)));
    const auto all_are_stable = [&](double time_step) {
        return std::ranges::all_of(
            frequencies, [&](double omega) { return is_stable(integrator, omega, damping.ratio(omega), time_step); });
    };
    double largest_rate = 0.0; // of what oscillates or, beyond critical damping, comes to rest
    for (const double omega : frequencies) {
        const double ratio = std::max(damping.ratio(omega), 1.0);
        largest_rate = std::max(largest_rate, omega * (ratio + std::sqrt(ratio * ratio - 1.0)));
    }
    const bool is_damped = damping.alpha > 0.0 || damping.beta > 0.0;
    double good = usual_first_try / largest_rate;
    if (is_damped && !all_are_stable(good))
        good = smallest_damped_try / highest;
    if (!all_are_stable(good))
        return 0.0;
    double bad = good * ratio;
    while (all_are_stable(bad)) {
        good = bad;
        bad *= ratio;
        if (bad * highest > largest_try)
            return std::numeric_limits<double>::infinity();
    }
    for (int i = 0; i < num_bisections; ++i) {
        const double middle = 0.5 * (good + bad);
        (all_are_stable(middle) ? good : bad) = middle;
    }
    return good;
}

const Integrator &find_integrator(const std::string &name, std::span<const Integrator> known) {
    return support::find_named(known, name, "integrator");
}

} // namespace livermark::msm
