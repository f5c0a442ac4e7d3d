#include "msm/spectrum.hpp"

#include <Spectra/SymEigsShiftSolver.h>
#include <Spectra/SymEigsSolver.h>

#include <Eigen/CholmodSupport>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <stdexcept>

#include "core/input_error.hpp"
#include "msm/free_components.hpp"

namespace livermark::msm {

namespace {

using Field = std::vector<core::Vector3>;

/// Lanczos's method finds the copies of a repeated frequency one after the other, by rounding; a few more than are
/// asked for keep the last copy of the last one from being left out.
constexpr int num_spare = 5;
/// Of 1 / omega^2.
constexpr double relative_tolerance = 1e-13;
/// Of the largest omega^2: its residual bounds the error of an eigenvalue.
constexpr double largest_tolerance = 1e-9;
constexpr int most_restarts = 1000;
constexpr Eigen::Index num_vectors_for_largest = 40;
/// Below this ratio of the smallest to the largest pivot nothing but rounding is left of the smallest one: springs free
/// to move gave 2.4e-13 or less, a rod a hundred times longer than wide and held at one end 6e-7.
constexpr double singular_pivot_ratio = 1e-11;

/// m^-1/2 of every free component.
Eigen::VectorXd inverse_root_mass(const ElasticBody &body, const FreeComponents &free) {
    Field root;
    root.reserve(body.node_mass.size());
    for (const double mass : body.node_mass)
        root.emplace_back(core::Vector3::Constant(1.0 / std::sqrt(mass)));
    return free.gather(root);
}

/// M^-1/2 K M^-1/2 as a Cholesky factor, and its inverse as Spectra asks for it.
class InverseStiffness : private Eigen::CholmodSupernodalLLT<Eigen::SparseMatrix<double>> {
  public:
    using Scalar = double;
    explicit InverseStiffness(const Eigen::SparseMatrix<double> &matrix) {
        cholmod().print = 0;
        compute(matrix);
    }

    bool is_regular() {
        return info() == Eigen::Success && cholmod_rcond(m_cholmodFactor, &cholmod()) > singular_pivot_ratio;
    }
    Eigen::Index rows() const { return CholmodSupernodalLLT::rows(); }
    Eigen::Index cols() const { return CholmodSupernodalLLT::cols(); }
    void set_shift(double) {} // it is zero, and the factor is there
    void perform_op(const double *x, double *y) const {
        Eigen::VectorXd::Map(y, rows()) = solve(Eigen::VectorXd::Map(x, rows()));
    }
};

/// y = M^-1/2 K M^-1/2 x, term by term, as Spectra asks for it. At rest the dashpots of a term act as K would.
class ScaledStiffness {
  public:
    using Scalar = double;
    ScaledStiffness(const ElasticBody &body, const Field &positions, const FreeComponents &free)
        : body_(body), free_(free), inverse_root_mass_(inverse_root_mass(body, free)), rest_(to_unknowns(positions)),
          at_rest_(product(Eigen::VectorXd::Zero(rest_.size()))) {}

    Eigen::Index rows() const { return free_.size(); }
    Eigen::Index cols() const { return free_.size(); }
    void perform_op(const double *x, double *y) const {
        displacement_.assign(body_.node_mass.size(), core::Vector3::Zero());
        free_.add(displacement_, Eigen::VectorXd::Map(x, rows()).cwiseProduct(inverse_root_mass_), 1.0);
        const Eigen::VectorXd force = product(to_unknowns(displacement_)) - at_rest_;
        Eigen::VectorXd::Map(y, rows()) = free_.gather(to_field(force)).cwiseProduct(inverse_root_mass_);
    }

  private:
    /// K v, and the forces that rounding leaves at rest.
    Eigen::VectorXd product(const Eigen::VectorXd &v) const {
        Eigen::VectorXd force = Eigen::VectorXd::Zero(v.size());
        for (const auto &term : body_.terms)
            term->add_force(rest_, v, 1.0, force);
        return -force;
    }

    const ElasticBody &body_;
    const FreeComponents &free_;
    Eigen::VectorXd inverse_root_mass_;
    Eigen::VectorXd rest_, at_rest_;
    mutable Field displacement_;
};

/// Lanczos's method has no room in fewer unknowns than it keeps vectors, but there the matrix can be written down.
double largest_of_few(const ScaledStiffness &stiffness) {
    Eigen::MatrixXd matrix(stiffness.rows(), stiffness.cols());
    const Eigen::MatrixXd unit = Eigen::MatrixXd::Identity(matrix.rows(), matrix.cols());
    for (Eigen::Index c = 0; c < matrix.cols(); ++c)
        stiffness.perform_op(unit.col(c).data(), matrix.col(c).data());
    return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix, Eigen::EigenvaluesOnly).eigenvalues().maxCoeff();
}

/// Adds a mode to others: phi = M^-1/2 times an eigenvector of norm 1, and of the two signs always the same.
void add_shape(Field &shapes, Eigen::VectorXd values, const FreeComponents &free, std::size_t num_nodes) {
    Eigen::Index largest = 0;
    values.cwiseAbs().maxCoeff(&largest);
    Field shape(num_nodes, core::Vector3::Zero());
    free.add(shape, values, std::copysign(1.0, values[largest]));
    shapes.insert(shapes.end(), shape.begin(), shape.end());
}

} // namespace

core::Modes lowest_modes(const ElasticBody &body, const Field &positions, const NodalConditions &conditions,
                         int count) {
    const auto start = std::chrono::steady_clock::now();
    const FreeComponents free(conditions.displacement);
    if (count < 1 || count >= free.size())
        throw core::InputError(
            fmt::format("a body with {} free unknowns does not have the {} modes that are asked for; "
                        "ask for at least one and for fewer than that",
                        free.size(), count));
    const auto scale = inverse_root_mass(body, free);
    InverseStiffness inverse_stiffness(
        scale.asDiagonal() * free.restrict(elastic_hessian(body, positions, Tangent::exact)) * scale.asDiagonal());
    if (!inverse_stiffness.is_regular())
        throw core::InputError("what is held leaves the body, or a part of it, free to move, so there are modes "
                               "without a frequency; hold the body in all six ways");
    const auto num_wanted = std::min<Eigen::Index>(count + num_spare, free.size() - 1);
    const auto num_vectors = std::min(2 * num_wanted + 10, free.size());
    Spectra::SymEigsShiftSolver<InverseStiffness> lanczos(inverse_stiffness, num_wanted, num_vectors, 0.0);
    lanczos.init();
    lanczos.compute(Spectra::SortRule::LargestMagn, most_restarts, relative_tolerance, Spectra::SortRule::SmallestAlge);
    if (lanczos.info() != Spectra::CompInfo::Successful)
        throw std::runtime_error(
            fmt::format("the modes did not converge in {} restarts of Lanczos's method", most_restarts));

    core::Modes modes;
    const Eigen::VectorXd squares = lanczos.eigenvalues();
    const Eigen::MatrixXd vectors = lanczos.eigenvectors();
    modes.shape.reserve(static_cast<std::size_t>(count) * positions.size());
    for (int mode = 0; mode < count; ++mode) {
        modes.angular_frequency.push_back(std::sqrt(squares[mode]));
        add_shape(modes.shape, scale.cwiseProduct(vectors.col(mode).normalized()), free, positions.size());
    }
    modes.degrees_of_freedom = static_cast<std::int64_t>(3 * positions.size());
    modes.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return modes;
}

double largest_angular_frequency(const ElasticBody &body, const Field &positions, const NodalConditions &conditions) {
    const FreeComponents free(conditions.displacement);
    if (free.size() == 0)
        return 0.0;
    ScaledStiffness stiffness(body, positions, free);
    if (free.size() <= num_vectors_for_largest)
        return std::sqrt(std::max(0.0, largest_of_few(stiffness)));
    // Three are asked for, so that a near copy of the largest is told from it and does not slow it down.
    Spectra::SymEigsSolver<ScaledStiffness> lanczos(stiffness, 3, num_vectors_for_largest);
    lanczos.init(); // from a random vector of fixed seed
    lanczos.compute(Spectra::SortRule::LargestAlge, most_restarts, largest_tolerance, Spectra::SortRule::LargestAlge);
    if (lanczos.info() != Spectra::CompInfo::Successful)
        throw std::runtime_error(
            fmt::format("the largest frequency did not converge in {} restarts of Lanczos's method", most_restarts));
    return std::sqrt(lanczos.eigenvalues()[0]);
}

double gershgorin_angular_frequency(const ElasticBody &body, const Field &positions,
                                    const NodalConditions &conditions) {
    std::vector<Eigen::Matrix3d> block(body.node_mass.size(), Eigen::Matrix3d::Zero());
    for (const auto &term : body.terms)
        term->add_block_bound(to_unknowns(positions), block);
    double largest = 0.0;
    for (std::size_t i = 0; i < block.size(); ++i) {
        for (int c = 0; c < 3; ++c)
            if (!std::isnan(conditions.displacement[i][c])) {
                block[i].row(c).setZero();
                block[i].col(c).setZero();
            }
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(block[i], Eigen::EigenvaluesOnly);
        largest = std::max(largest, eigen.eigenvalues()[2] / body.node_mass[i]);
    }
    return std::sqrt(largest);
}

} // namespace livermark::msm
