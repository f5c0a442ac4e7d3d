#include "msm/dynamics/spectrum.hpp"

#include <Spectra/SymEigsShiftSolver.h>

#include <Eigen/CholmodSupport>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <stdexcept>

#include "core/support/factors/blas_memory.hpp"
#include "core/support/input_error.hpp"
#include "msm/dynamics/time_step.hpp"

namespace livermark::msm {

namespace {

using Field = std::vector<core::Vector3>;

/// Lanczos's method finds the copies of a repeated frequency one after the other, by rounding; a few more than are
/// asked for keep the last copy of the last one from being left out.
constexpr int num_spare = 5;
/// Of 1 / omega^2.
constexpr double relative_tolerance = 1e-13;
constexpr int most_restarts_of_spectrum = 1000;
/// Below this ratio of the smallest to the largest pivot nothing but rounding is left of the smallest one: springs free
/// to move gave 2.4e-13 or less, a rod a hundred times longer than wide and constrained at one end 6e-7.
constexpr double singular_pivot_ratio = 1e-11;

/// M^-1/2 K M^-1/2 as a Cholesky factor, and its inverse with scaled masses as Spectra asks for it.
class InverseStiffness : private Eigen::CholmodSupernodalLLT<Eigen::SparseMatrix<double>> {
  public:
    using Scalar = double;
    explicit InverseStiffness(const Eigen::SparseMatrix<double> &matrix) {
        support::keep_openmp_in_this_thread();
        cholmod().print = 0;
        {
            const auto lock = support::only_ordering();
            analyzePattern(matrix);
        }
        const auto lock = support::only_in_blas();
        factorize(matrix);
    }

    bool is_regular() {
        return info() == Eigen::Success && cholmod_rcond(m_cholmodFactor, &cholmod()) > singular_pivot_ratio;
    }
    Eigen::Index rows() const { return CholmodSupernodalLLT::rows(); }
    Eigen::Index cols() const { return CholmodSupernodalLLT::cols(); }
    void set_shift(double) {} // it is zero, and the factor is there
    /// M'^1/2 K^-1 M'^1/2 with M' the scaled mass, of which M^-1/2 M'^1/2 is known to `scaled`.
    void perform_op(const double *x, double *y) const {
        const Eigen::VectorXd weighted = scaled(Eigen::VectorXd::Map(x, rows()));
        Eigen::VectorXd solution;
        {
            const auto lock = support::only_in_blas();
            solution = solve(weighted);
        }
        Eigen::VectorXd::Map(y, rows()) = scaled(solution);
    }

    std::function<Eigen::VectorXd(const Eigen::VectorXd &)> scaled = [](const Eigen::VectorXd &x) { return x; };
};

/// M^1/2 times what scale_deformation() makes of M^-1/2 x.
Eigen::VectorXd scaled_deformation(const Eigen::VectorXd &x, double power, const MassScaling &scaling,
                                   const ElasticBody &body, const Field &positions, const FreeComponents &free) {
    const auto scale = inverse_root_mass(body.node_mass, free);
    Field field(positions.size(), core::Vector3::Zero());
    free.add(field, scale.cwiseProduct(x), 1.0);
    auto unknowns = to_unknowns(field);
    scale_deformation(scaling, power, to_unknowns(positions), unknowns);
    return free.gather(to_field(unknowns)).cwiseQuotient(scale);
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

core::Modes lowest_modes(const ElasticBody &body, const Field &positions, const NodalConditions &conditions, int count,
                         const MassScaling &scaling) {
    const auto start = std::chrono::steady_clock::now();
    const FreeComponents free(conditions.displacement);
    if (count < 1 || count >= free.size())
        throw support::InputError(
            fmt::format("a body with {} free unknowns does not have the {} modes that are asked for; "
                        "ask for at least one and for fewer than that",
                        free.size(), count));
    const auto scale = inverse_root_mass(body.node_mass, free);
    InverseStiffness inverse_stiffness(
        scale.asDiagonal() * free.restrict(elastic_hessian(body, positions, Tangent::exact)) * scale.asDiagonal());
    if (!inverse_stiffness.is_regular())
        throw support::InputError("the constraints leave the body, or a part of it, free to move, so there are modes "
                                  "of zero frequency; constrain all six rigid body motions");
    const auto scaled = [&](const Eigen::VectorXd &x, double power) {
        return scaling.parts.empty() ? x : scaled_deformation(x, power, scaling, body, positions, free);
    };
    inverse_stiffness.scaled = [&](const Eigen::VectorXd &x) { return scaled(x, 0.5); };
    const auto num_wanted = std::min<Eigen::Index>(count + num_spare, free.size() - 1);
    const auto num_vectors = std::min(2 * num_wanted + 10, free.size());
    Spectra::SymEigsShiftSolver<InverseStiffness> lanczos(inverse_stiffness, num_wanted, num_vectors, 0.0);
    lanczos.init();
    lanczos.compute(Spectra::SortRule::LargestMagn, most_restarts_of_spectrum, relative_tolerance,
                    Spectra::SortRule::SmallestAlge);
    if (lanczos.info() != Spectra::CompInfo::Successful)
        throw std::runtime_error(
            fmt::format("the modes did not converge in {} restarts of Lanczos's method", most_restarts_of_spectrum));

    core::Modes modes;
    const Eigen::VectorXd squares = lanczos.eigenvalues();
    const Eigen::MatrixXd vectors = lanczos.eigenvectors();
    modes.shape.reserve(static_cast<std::size_t>(count) * positions.size());
    for (int mode = 0; mode < count; ++mode) {
        modes.angular_frequency.push_back(std::sqrt(squares[mode]));
        add_shape(modes.shape, scale.cwiseProduct(scaled(vectors.col(mode).normalized(), -0.5)), free,
                  positions.size());
    }
    modes.degrees_of_freedom = static_cast<std::int64_t>(3 * positions.size());
    modes.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return modes;
}

} // namespace livermark::msm
