#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace livermark::msm {

/// Displacements of n unknowns and how they move.
struct State {
    Eigen::VectorXd displacement; ///< (n) u [m]
    Eigen::VectorXd velocity;     ///< (n) v [m/s]
};

/// M u'' = F(u, u') with a diagonal M. Unknowns that are constrained have no acceleration, and nothing moves them.
struct EquationOfMotion {
    Eigen::VectorXd mass; ///< (n) diagonal of M [kg]
    /// a = M^-1 F(u, v), shape (n) [m/s^2]; the third argument has its size
    std::function<void(const Eigen::VectorXd &u, const Eigen::VectorXd &v, Eigen::VectorXd &a)> acceleration;
    /// M + d D + k K with D = -dF/dv and K = -dF/du at (u, 0), or a positive definite matrix close to it; the rows and
    /// columns of constrained unknowns are those of M. Asked for by implicit integrators only.
    std::function<Eigen::SparseMatrix<double>(const Eigen::VectorXd &u, double d, double k)> effective_mass;
};

/// A stage of a Runge-Kutta-Chebyshev method, from those before. For y' = f(y), with the stages as differences
/// D_j = Y_j - y_0 from where the step starts, D_0 = 0, and F_j = f(Y_j),
///     D_1 = mu~_1 h F_0,   D_j = mu_j D_(j-1) + nu_j D_(j-2) + mu~_j h F_(j-1) + gamma~_j h F_0.
struct ChebyshevStage {
    double mu, nu;                ///< 0 for the first
    double mu_tilde, gamma_tilde; ///< gamma~_1 = 0
    double time;                  ///< c_j: stage j stands at t_0 + c_j h; 1 for the last
};

/// The method of second order of Sommeijer, Shampine, Verwer 1998, J. Comput. Appl. Math. 88. Its stability polynomial
/// is R(z) = 1 - b_s T_s(w_0) + b_s T_s(w_0 + w_1 z), with w_0 = 1 + epsilon / s^2, w_1 = T_s'(w_0) / T_s''(w_0) and
/// b_s = T_s''(w_0) / T_s'(w_0)^2: stable on the real axis from z = -(w_0 + 1) / w_1 to 0, which is about 2/3 (s^2 - 1)
/// (1 - 2/15 epsilon) long.
/// @param num_stages  s >= 2
/// @param epsilon     > 0; the larger, the wider is the region of stability around the negative real axis, and the
///   shorter
/// @return stages 1 to s
std::vector<ChebyshevStage> chebyshev_stages(int num_stages, double epsilon);

/// Stages of the integrator runge_kutta_chebyshev.
std::vector<ChebyshevStage> chebyshev_stages(int num_stages);

/// A step gets longer with s^2, until it is so long that accuracy limits it: on livers with tumours, of 5 to 20 stages
/// these need the fewest forces for an error of 3e-4 of the motion.
inline constexpr int usual_num_stages = 8;

/// Moves a state on by one step.
using Step = std::function<void(State &)>;

/// A rule that takes an equation of motion from one time to the next. One file each in integrators/ or
/// implicit_integrators/, named as the integrator.
struct Integrator {
    std::string name;        ///< the file stem; set by the table
    std::string summary;     ///< one line
    std::string source;      ///< literature reference
    int order = 1;           ///< of the error after a given time in the length of the step
    bool is_explicit = true; ///< takes no more than accelerations
    bool is_symplectic = false;
    /// Bears steps under strong damping that are so long that what limits them is not stability but accuracy.
    bool is_stabilised = false;
    int forces_per_step = 1; ///< evaluations of the forces; 0 if a step takes as many as it needs
    /// Steps of one length; what it returns keeps its scratch space, so each thread needs its own.
    /// @param equation   kept alive and unchanged by the caller
    /// @param time_step  h [s], > 0
    std::function<Step(const EquationOfMotion &equation, double time_step)> prepare;
    /// The same method with another number of forces in a step, >= 2; nullptr if it has but one. Stable steps under
    /// strong damping are about as long as forces_per_step^2 - 1 of them.
    Integrator (*with_forces_per_step)(int number) = nullptr;
};

/// Every integrator of integrators/, in alphabetical order: the explicit ones.
std::span<const Integrator> all_integrators();

/// @param known  where to look
/// @throws support::InputError if there is none of that name
const Integrator &find_integrator(const std::string &name, std::span<const Integrator> known = all_integrators());

/// Every integrator of implicit_integrators/, in alphabetical order: those that solve systems of equations in each
/// step. They stand apart because their factors are CHOLMOD's, which the explicit ones do without.
std::span<const Integrator> all_implicit_integrators();

/// The explicit and the implicit ones together, in alphabetical order.
const std::vector<Integrator> &known_integrators();

/// Kernels for the forces of steps in time. All give the same motion, to the digits that they have.
enum class StepKernel {
    scalar,      ///< the slow, obvious one, which knows every body and integrator
    simd_double, ///< vector units, double precision
    simd_float   ///< vector units, forces in single precision; see FastSteps
};

/// The word for a kernel in options and result files.
const char *to_string(StepKernel kernel);

/// Choices of a user about steps in time.
struct TimeStepping {
    /// A name of all_integrators(); by default runge_kutta_4 or runge_kutta_chebyshev, whichever needs fewer forces.
    std::optional<std::string> integrator{};
    /// Longest step [s], > 0; by default a safe part of the critical one. Where it is asked for, a step has the usual
    /// number of forces.
    std::optional<double> time_step{};
    bool force = false; ///< take it even if it is too long
    StepKernel kernel = StepKernel::simd_float;
};

} // namespace livermark::msm
