#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <vector>

#include "core/load_case.hpp"
#include "core/problem.hpp"
#include "msm/elastic_body.hpp"
#include "msm/integrator.hpp"

namespace livermark::msm {

// Selective mass scaling: a stiff inclusion, say a tumour, is given more mass for its fast deformations, so that
// explicit steps may be as long as those of the tissue around it. With Q the projection onto what is left alone, rigid
// motions of the inclusion where it is and its slow deformations turned with it, orthogonal in its masses M, and a
// factor f >= 1,
//   a = c + (Q + (I - Q) / f) (M^-1 F - c),   so the mass is M (Q + f (I - Q)) for what is seen from the inclusion,
// where c are the centripetal and Coriolis accelerations of an inclusion that turns.
// Forces and torques on the inclusion are as before, and so linear and angular momentum of the body are kept to
// rounding, and every equilibrium stays. What changes is how fast the inclusion deforms, which it hardly does.
// (Olovsson, Simonsson, Unosson 2005, Int. J. Numer. Meth. Engng. 63, scale the mass of each element so; one
// projection for a whole inclusion has an inverse in closed form.)

/// Nodes that move nearly as a rigid body, n of them.
struct ScaledRegion {
    std::vector<int> nodes; ///< at least 4, free in all components
    double factor = 1.0;    ///< f, >= 1
    Eigen::VectorXd mass;   ///< (n) [kg]
    Eigen::Matrix3Xd rest;  ///< (3, n) at rest, from the centre of mass [m]
    /// (3n, m) slow deformations about rest: orthonormal in the masses and orthogonal to rigid motions [kg^-1/2]
    Eigen::MatrixXd slow;
};

/// No node is in two parts.
struct MassScaling {
    std::vector<ScaledRegion> parts; ///< none: nothing is scaled
};

/// Nodes of each connected part of a body that is stiffer than most of it: of regions whose (lambda + 2 mu) / density
/// is more than twice that of the region of the largest volume.
/// @return ascending; none for a body of one material
std::vector<std::vector<int>> stiff_parts(const core::Body &body);

/// Scales the stiff parts so that each alone, with all other nodes constrained, has no higher frequency than the rest
/// of the body has with the stiff parts constrained: f = (omega_part / omega_rest)^2. Slow deformations are those
/// linear and quadratic fields of a part that, by Ritz's method, have a frequency below 0.9 omega_rest. Parts that need
/// no scaling are left out.
/// @param springs     of the body
/// @param conditions  constrained nodes belong to no part
MassScaling scale_masses(const core::Body &body, const ElasticBody &springs, const NodalConditions &conditions);

/// The same factors where more is constrained. A part that loses nodes has no slow deformations any more.
MassScaling constrained(const MassScaling &scaling, const NodalConditions &conditions);

/// Rotation of a part since rest, of its moment sum of m x rest^T with x and rest from their centres of mass.
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d &moment);

/// Takes what a field does besides moving a part as a rigid body, or slowly deforming it, times a factor. Its momentum
/// and angular momentum about any point stay as they are.
/// @param x       shape (3, n), where the nodes are [m], not all on a line
/// @param factor  > 0
/// @param field   shape (3, n), velocities, accelerations or small displacements
void scale_deformation(const ScaledRegion &part, const Eigen::Matrix3Xd &x, double factor, Eigen::Matrix3Xd &field);

/// The same of all parts, each with f^power.
/// @param x, field   shape (3N)
void scale_deformation(const MassScaling &scaling, double power, const Eigen::VectorXd &x, Eigen::VectorXd &field);

/// From accelerations M^-1 F to those of the scaled masses.
/// @param x, v          shape (3, n), positions [m] and velocities [m/s]
/// @param acceleration  shape (3, n) [m/s^2]
void scale_acceleration(const ScaledRegion &part, const Eigen::Matrix3Xd &x, const Eigen::Matrix3Xd &v,
                        Eigen::Matrix3Xd &acceleration);

/// The same of all parts.
/// @param x, v, acceleration  shape (3N)
void scale_acceleration(const MassScaling &scaling, const Eigen::VectorXd &x, const Eigen::VectorXd &v,
                        Eigen::VectorXd &acceleration);

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
