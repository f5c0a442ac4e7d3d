#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <vector>

#include "core/load_case.hpp"
#include "msm/dynamics/mass_scaling.hpp"
#include "msm/elastic_body.hpp"
#include "msm/integrator.hpp"

namespace livermark::msm {

/// Which of the 3N displacement components are unknown, and their numbers among the unknowns.
class FreeComponents {
  public:
    explicit FreeComponents(const Field &prescribed);
    bool operator==(const FreeComponents &) const = default;

    Eigen::Index size() const { return size_; }
    /// Number of a component among the unknowns, -1 where it is prescribed.
    Eigen::Index number(Eigen::Index component) const { return number_[component]; }
    bool is_free(Eigen::Index component) const { return number_[component] >= 0; }
    /// Freedom of all components, shape (3N).
    std::vector<bool> are_free() const;

    /// The free components of a nodal field.
    Eigen::VectorXd gather(const Field &field) const;
    /// Adds scale * values to the free components of a nodal field.
    void add(Field &field, const Eigen::VectorXd &values, double scale) const;
    /// Rows and columns of the free components.
    Eigen::SparseMatrix<double> restrict(const Eigen::SparseMatrix<double> &matrix) const;

  private:
    std::vector<Eigen::Index> number_; // (3N) number among the unknowns, -1 where prescribed
    Eigen::Index size_ = 0;
};

/// m^-1/2 of every free component.
/// @param node_mass  shape (N) [kg], > 0
/// @return shape (free.size()) [kg^-1/2]
Eigen::VectorXd inverse_root_mass(const std::vector<double> &node_mass, const FreeComponents &free);

// Limit of explicit steps: the highest frequency of a body linearised at rest, K phi = omega^2 M phi with K the
// material tangent and M the node masses. What is prescribed is constrained at zero, whatever its value; loads do not
// count.

/// The largest omega, which sets the critical time step of every explicit integrator, to a relative accuracy of 1e-9 if
/// no other is asked for:
/// Lanczos's method on M^-1/2 K M^-1/2 applied term by term, without a matrix. The body may be free to move, and the
/// same body gives the same bits.
/// @param body        masses > 0, at rest at the positions
/// @param positions   shape (N) [m]
/// @param conditions  of the nodes
/// @param scaling     of the masses
/// @param tolerance   of omega^2, as a part of it
/// @return [rad/s]; zero if nothing can move
/// @throws std::runtime_error if the iteration does not converge
double largest_angular_frequency(const ElasticBody &body, const Field &positions, const NodalConditions &conditions,
                                 const MassScaling &scaling = {}, double tolerance = 1e-9);

/// The mode of the largest omega.
struct HighestMode {
    double angular_frequency = 0.0; ///< [rad/s]
    Eigen::VectorXd shape;          ///< (3N) M^1/2 phi, of length 1; zero where constrained
    FreeComponents free{{}};
};

/// @throws std::runtime_error if the iteration does not converge
HighestMode highest_mode(const ElasticBody &body, const Field &positions, const NodalConditions &conditions);

/// The largest omega by the highest mode of the same body where it is constrained less, for bodies that are constrained
/// here and there one after the other. What holds more has no frequency above it (Cauchy's interlacing), and none of
/// its largest is below the Rayleigh quotient of any trial vector: a mode that hardly reaches what is constrained
/// beside leaves nothing between both, which a single product shows. Otherwise Lanczos's method looks for another one.
/// @param less  of the same body; Lanczos's method is taken as well where that holds something else
double largest_angular_frequency(const ElasticBody &body, const Field &positions, const NodalConditions &conditions,
                                 const HighestMode &less);

/// A bound on the largest omega from above for the price of one pass over the terms: Gershgorin's, with the 3 x 3 block
/// of each node in place of a row,
///   omega^2 <= max_i lambda_max(B_ii) / m_i   because   u^T K u <= sum over nodes of u_i^T B_ii u_i,
/// with the blocks of ElasticTerm::add_block_bound(). Those of springs are 2 sum over the springs at node i of k n n^T;
/// they know in which directions the springs of a node pull, and the bound is never above 2 max_i (sum_j k_ij) / m_i.
/// B_ii is taken over the free components of the node.
/// @param body        masses > 0, at rest at the positions
/// @param positions   shape (N) [m]
/// @param conditions  of the nodes
/// @return [rad/s]; zero if nothing can move
double gershgorin_angular_frequency(const ElasticBody &body, const Field &positions, const NodalConditions &conditions);

/// The same bound node by node, (lambda_max(B_ii) / m_i)^1/2: which nodes ask for short steps.
/// @return shape (N) [rad/s]; zero where nothing can move
std::vector<double> nodal_frequency_bounds(const ElasticBody &body, const Field &positions,
                                           const NodalConditions &conditions);

/// Whether an oscillation u'' + 2 zeta omega u' + omega^2 u = 0 stays within bounds: whether both eigenvalues of the 2
/// x 2 matrix that takes (omega u, v) from one time to the next lie in the unit circle. The matrix is found by taking
/// the step, so this holds for every integrator.
/// @param omega          undamped angular frequency [rad/s], > 0
/// @param damping_ratio  zeta, >= 0
/// @param time_step      [s], > 0
bool is_stable(const Integrator &integrator, double omega, double damping_ratio, double time_step);

/// Growth of the fastest growing oscillation in one step at most, where angular frequencies and damping ratios are as
/// in critical_time_step(): the largest modulus of an eigenvalue of that matrix. For steps that are clearly stable or
/// not; near 1 half the digits may be lost, so is_stable() does not ask it.
double largest_amplification(const Integrator &integrator, const core::RayleighDamping &damping, double lowest,
                             double highest, double time_step);

/// The largest step at which no mode grows, where all angular frequencies lie between the two and have the damping
/// ratios that Rayleigh damping gives them.
/// @param lowest, highest  [rad/s], 0 < lowest <= highest
/// @return [s]; infinity for an integrator that is stable at every step, 0 for one that is stable at none
double critical_time_step(const Integrator &integrator, const core::RayleighDamping &damping, double lowest,
                          double highest);

/// Lowest frequency at which runs look at the damping, as a part of the highest.
inline constexpr double lowest_damped_part = 1e-3;

/// Part of the critical time step that runs take by default: the springs get stiffer as they are stretched.
inline constexpr double default_safety_factor = 0.8;

} // namespace livermark::msm
