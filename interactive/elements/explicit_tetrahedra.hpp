#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "interactive/elements/energies.hpp"
#include "interactive/elements/point_springs.hpp"
#include "interactive/kernels/method_steps.hpp"
#include "interactive/method.hpp"

namespace livermark::interactive {

/// The longest stable step of central differences at rest, 2 / omega with omega the highest angular frequency of
/// K phi = omega^2 M phi, K the second derivative of the energy, where what is constrained stays: Lanczos's method on
/// differences of forces, without a matrix, to a ten thousandth of omega^2. The same scene gives the same bits.
/// @return [s]; infinity if nothing can move
/// @throws std::runtime_error if the iteration does not converge
double critical_time_step(const Energy &energy, const Scene &scene);

/// A bound on it from below, without an iteration: 2 / omega with omega the highest angular frequency that any
/// tetrahedron has with its own share of the masses. (Irons, Treharne 1971; Belytschko, Liu, Moran 2000, Nonlinear
/// Finite Elements for Continua and Structures, 6.2.4)
/// @param node_mass  shape (N) [kg]; each tetrahedron's share goes by its volume
/// @return [s]
double critical_time_step_bound(const std::vector<Tetrahedron> &tetrahedra, const std::vector<double> &node_mass);

/// Explicit steps of neo-Hookean tetrahedra, linear or those of quadratic_scene(). An iteration is one step of central
/// differences, h = time step over iterations, with velocities half a step behind:
///     v = ((1 - alpha h / 2) v + h (f + f_ext) / m) / (1 + alpha h / 2),   x += h v.
/// Constrained nodes go to their targets in equal parts. Longer steps than critical_time_step() blow up. What a ball
/// that touches exerts takes part in the step. What acts after a step is given the nodes of the mesh alone. The state
/// is what method_steps.hpp moves, and positions and velocities are that state after each step.
/// (Belytschko, Liu, Moran 2000, Nonlinear Finite Elements for Continua and Structures, box 6.1 and section 10.7)
class ExplicitTetrahedra : public SimulationInRows {
  public:
    /// @param energy   of the tetrahedra with that pressure, and of the springs
    /// @param springs  beside the tetrahedra
    ExplicitTetrahedra(Scene given, kernels::Pressure pressure, std::unique_ptr<Energy> energy,
                       std::span<const PointSpring> springs);

    void step(double time_step, int iterations) override;
    /// Found when it is asked for.
    double critical_time_step() const override;
    bool correct_steps(const std::shared_ptr<StepCorrection> &correction) override;
    bool act_after_steps(const AfterStep &action) override;
    Cost cost(int iterations) const override;
    Orders orders() const override { return rows_.orders(); }
    const Energy &energy() const override { return *energy_; }

  private:
    kernels::NodeRows &rows() override { return rows_; }
    void take_corrected_step(double h);
    void push_out(const core::BallStep &step, double h);

    kernels::Pressure pressure_;
    std::unique_ptr<Energy> energy_;
    kernels::ExplicitRows rows_;
    std::shared_ptr<StepCorrection> correction_; ///< null if there is none
    AfterStep after_step_;
    mutable std::optional<double> critical_time_step_;
};

/// The same with the capsule and the vessels of the body as springs beside the tetrahedra.
/// @tparam Elements     energy of the tetrahedra with that pressure
/// @param of_elements  what it is made of
template <class Elements, class... Arguments>
std::unique_ptr<Simulation> explicit_with_springs(const Scene &scene, kernels::Pressure pressure,
                                                  Arguments &&...of_elements) {
    auto energy =
        std::make_unique<WithSprings<Elements>>(capsule_and_vessels(scene), std::forward<Arguments>(of_elements)...);
    const auto &springs = energy->point_springs();
    return std::make_unique<ExplicitTetrahedra>(scene, pressure, std::move(energy), springs);
}

/// A tetrahedron with ten nodes: the corners of a linear one, and the middles of its edges in the order of
/// core::tetrahedron_edges. It has straight edges at rest, so its deformation gradient is linear in it: that at a
/// quadrature point is a mean of those at the corners,
///     F(corner k) = (3 x_k (x) d_k + sum over the other corners j of (4 x_kj - x_j) (x) d_j),
/// with d the gradients of the linear shape functions and x_kj the middle of the edge from k to j.
struct QuadraticTetrahedron {
    static constexpr int num_points = 4; ///< of the quadrature

    /// Matrices at the corners or the quadrature points.
    using AtPoints = std::array<Matrix3, num_points>;

    std::array<int, 10> nodes;
    Matrix3 inverse_edges; ///< of Tetrahedron, B [1/m]
    double volume;         ///< at rest [m^3]
    double mu, lambda;     ///< Lame parameters [Pa]

    /// Volume of a quadrature point [m^3].
    double weight() const { return volume / num_points; }

    /// F at the quadrature points.
    AtPoints gradients(const Field &x) const;

    /// f -= sum over the points of weight P grad N [N], with P the first Piola-Kirchhoff stress [Pa].
    void add_forces(const AtPoints &stresses, Field &f) const;

    /// Gradients of the ten shape functions at rest at a quadrature point, shape (10, 3) [1/m].
    Eigen::Matrix<double, 10, 3> shape_gradients(int point) const;

    /// Second derivatives at x of its neo-Hookean energy, of component c of node a at 3 a + c [N/m].
    /// @param is_projected  whether those of each point are made positive semidefinite
    Eigen::Matrix<double, 30, 30> stiffness(const Field &x, bool is_projected) const;
};

/// W = sum over the quadrature points of weight times the neo-Hookean density. The rule has four points, exact to
/// degree 2: what other codes take for quadratic tetrahedra.
/// (P. C. Hammer, A. H. Stroud 1956, Numerical integration over simplexes, Math. Tables Aids Comput. 10)
class QuadraticEnergy : public Energy {
  public:
    /// @param scene  of quadratic_scene()
    explicit QuadraticEnergy(const Scene &scene);

    double value(const Field &x) const override;
    void add_forces(const Field &x, Field &f) const override;
    void add_hessian(const Field &x, bool is_projected, Triplets &triplets) const override;

    const std::vector<QuadraticTetrahedron> &tetrahedra() const { return tetrahedra_; }

  private:
    std::vector<QuadraticTetrahedron> tetrahedra_;
};

/// A scene on linear tetrahedra with a node in the middle of each edge: edge e of core::edge_table() has node N + e.
/// Nodes on a boundary triangle whose corners are all constrained are so too, as in finite elements whose facets are.
/// Masses are lumped in proportion to the diagonal of the consistent matrix, a 36th of a tetrahedron's mass at a
/// corner and four 27ths at an edge, all positive (Hinton, Rock, Zienkiewicz 1976, Earthq. Engng Struct. Dyn. 4). A
/// tetrahedron's mass is what it has of the masses of its corners by its volume.
/// Dead forces stay at the corners, where they come in.
Scene quadratic_scene(Scene scene);

} // namespace livermark::interactive
