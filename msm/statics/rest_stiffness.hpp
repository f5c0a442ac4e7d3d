#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <cstddef>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/mesh/places.hpp"
#include "core/problem.hpp"
#include "core/solution.hpp"
#include "core/support/factors/sparse_cholesky.hpp"
#include "core/tool/needle/needle.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/elastic_body.hpp"

namespace livermark::msm {

/// A linear map that nobody has to write down.
using LinearMap = std::function<Eigen::VectorXd(const Eigen::VectorXd &)>;

/// A x = b by preconditioned conjugate gradients, in the flexible form of Golub and Ye 1999 (SIAM J. Sci. Comput. 21):
/// an inverse in single precision is a little different each time.
/// @param matrix     A, symmetric, of any size n
/// @param inverse    near A^-1, positive definite
/// @param tolerance  of |b - A x| over |b|
/// @param see        is shown each step and A times it
/// @return x of shape (n), or where it came to after the last step. Where a direction d bends downwards, d^T A d <= 0,
/// it
///   is what was found before, or d if that was the first one (Steihaug 1983, SIAM J. Numer. Anal. 20): downhill in
///   x^T A x / 2 - b^T x either way.
Eigen::VectorXd
conjugate_gradients(const LinearMap &matrix, const LinearMap &inverse, const Eigen::VectorXd &b, double tolerance,
                    int max_steps,
                    const std::function<void(const Eigen::VectorXd &, const Eigen::VectorXd &)> &see = {});

/// Inverse second derivative of an energy from the last steps downhill: a first inverse with their corrections of
/// rank two (limited-memory BFGS; the two loops of Nocedal 1980, Updating quasi-Newton matrices with limited storage,
/// Math. Comput. 35).
class LimitedMemory {
  public:
    /// The corrected inverse times a vector.
    /// @param first  positive definite
    Eigen::VectorXd times(const LinearMap &first, Eigen::VectorXd vector) const;

    /// Learns from a step and the change of the gradient on it. Where the energy bends downwards there is nothing to be
    /// learnt for an inverse that is to stay positive definite.
    void learn(Eigen::VectorXd step, Eigen::VectorXd change);

  private:
    struct Pair {
        Eigen::VectorXd step, change;
        double curvature;
    };
    std::deque<Pair> pairs_; // of the last 30 steps
};

/// The stiffness of a body at rest, and its factor on the components that are free. Load cases that constrain the same
/// components share one, and those that constrain few more than a common part one of that. Of a body with a
/// preconditioner the factor is that of the preconditioner's stiffness, and the linear answer is found by conjugate
/// gradients.
class RestStiffness {
  public:
    /// Constrains nothing yet.
    /// @param positions   shape (N) of rest [m]
    /// @param common      shape (N) as for constrain(), what more than one of the load cases to come constrain, maybe
    /// among more;
    ///                    empty if there is no such thing
    static RestStiffness shared(const ElasticBody &body, const Field &positions, Field common);
    /// Factor for a single set of constrained components.
    /// @param positions   shape (N) of rest [m]
    /// @param prescribed  see constrain()
    RestStiffness(const ElasticBody &body, const Field &positions, const Field &prescribed);

    /// Factors, unless the same components are constrained.
    /// @param prescribed  shape (N) displacement [m], NaN where a component is free; the values do not matter
    void constrain(const Field &prescribed);
    /// Whether the same components are constrained.
    bool constrains(const Field &prescribed) const;
    const FreeComponents &free() const { return free_; }
    /// If not, the body is not stiff in every direction and there is no factor.
    bool is_definite() const { return is_definite_; }
    /// Whether the factor is only near that of the body.
    bool is_approximate() const { return product_.has_value(); }
    /// K_ff^-1 f_f in single precision, see support::SparseCholesky::solve_single_precision(), only if it is definite.
    /// @param force  shape (free().size())
    Eigen::VectorXd inverse_times(const Eigen::VectorXd &force) const;
    /// Seconds that what is in use took, also when it was made for an earlier load case.
    double factor_seconds() const { return factor_seconds_ + constrain_seconds_; }
    /// The forces that the last digit of the positions makes [N].
    double rounding_force() const { return rounding_force_; }
    /// Solution of the linear body: K_ff u_f = f_f - K_fc u_c, to rounding or, where the factor is approximate, to
    /// 1e-10 of the load.
    /// @param force  shape (N) [N]
    /// @param memory  learns from the steps of conjugate gradients, if there are any
    /// @return shape (N) [m]; where it is not definite, the prescribed displacements alone
    Field solve(const Field &prescribed, const Field &force, LimitedMemory *memory = nullptr) const;

  private:
    RestStiffness(const ElasticBody &body, const Field &positions);
    Eigen::VectorXd product(const Eigen::VectorXd &displacement) const;
    Eigen::VectorXd by_conjugate_gradients(const Eigen::VectorXd &load, LimitedMemory *memory) const;
    bool factorise(const FreeComponents &rows);
    Eigen::VectorXd inverse_times(const Eigen::VectorXd &force, support::SparseCholesky::Solve solve) const;

    Eigen::SparseMatrix<double> stiffness_;   // (3N, 3N) of the body or its preconditioner
    std::optional<StiffnessProduct> product_; // of the body, if the matrix is not
    Eigen::VectorXd diagonal_;                // (3N) of the body [N/m]
    double extent_ = 0.0;                     // [m]
    Field common_;                            // (N), or empty
    FreeComponents free_{{}};                 // of what is constrained now
    std::optional<FreeComponents> rows_;      // of the factor: the same, or more; none if there is no factor
    support::SparseCholesky factor_;
    bool rows_are_definite_ = false;
    bool is_definite_ = false;
    double rounding_force_ = 0.0;
    double factor_seconds_ = 0.0;
    double constrain_seconds_ = 0.0;
};

/// Compliance of a body of point masses inside, linearised at rest: nodes take forces on places, and places the means
/// of displacements, with the weights of linear tetrahedra.
/// @param body  at rest on the mesh of the problem
/// @return without seconds
/// @throws support::InputError if the load case leaves the body free to move, or the springs do not hold it up
/// @throws std::invalid_argument if a place is outside the body
core::Compliance compliance(const ElasticBody &body, const core::Problem &problem,
                            std::span<const core::InteriorPlace> places);

/// A body of point masses that is pushed at places inside: nodes take forces on places, and places the means of
/// displacements, with the weights of linear tetrahedra. Each push is find_equilibrium() from the last one; where that
/// fails, forces go there in up to 32 parts. The compliance is that at rest.
/// @param body     at rest on the mesh of the problem
/// @param problem  what its load case constrains stays where it is at rest, and its loads do not act
/// @throws as compliance()
std::unique_ptr<core::PushedBody> pushed_springs(ElasticBody body, const core::Problem &problem,
                                                 std::span<const core::InteriorPlace> places);

/// Free vibrations of a body linearised at rest, K phi = omega^2 M phi with K the material tangent and M the node
/// masses. What is prescribed is constrained at zero, whatever its value; loads do not count.

/// The lowest modes by shift-invert about zero: Lanczos's method with implicit restarts (Spectra) for the largest
/// eigenvalues 1 / omega^2 of the inverse of M^-1/2 K M^-1/2, with one sparse Cholesky factor of it.
/// @param body        masses > 0, at rest at the positions
/// @param positions   shape (N) [m]
/// @param conditions  of the nodes
/// @param count       at least 1
/// @param scaling     of the masses
/// @return shapes of M-norm 1 with their largest entry positive
/// @throws support::InputError if what is constrained leaves the body free to move, or if it has fewer modes than that
/// @throws std::runtime_error if the iteration does not converge
core::Modes lowest_modes(const ElasticBody &body, const Field &positions, const NodalConditions &conditions, int count,
                         const MassScaling &scaling = {});

} // namespace livermark::msm
