#pragma once

#include <vector>

#include "interactive/elements/tetrahedra.hpp"
#include "interactive/energy.hpp"

namespace livermark::interactive {

/// The neo-Hookean energy with its pressure averaged around nodes, so that linear tetrahedra do not lock:
///     W = sum over the tetrahedra e of V_e mu_e / 2 (I1 - 3 - 2 ln J_e)
///       + sum over the nodes a of V_a lambda_a / 2 (ln J_a)^2,
/// with V_a a quarter of the volumes around a node, and J_a and lambda_a the means of J_e and lambda_e there, weighted
/// by volume. (Bonet, Burton 1998, Commun. Numer. Meth. Engng 14; Joldes, Wittek, Miller 2009, ibid. 25)
class NodalPressureEnergy : public Energy {
  public:
    explicit NodalPressureEnergy(const core::Body &body);

    double value(const Field &x) const override;
    void add_forces(const Field &x, Field &f) const override;
    void add_hessian(const Field &x, bool is_projected, Triplets &triplets) const override;

    const std::vector<Tetrahedron> &tetrahedra() const { return tetrahedra_; }

  private:
    Eigen::VectorXd nodal_jacobians(const Field &x) const;
    /// lambda ln J / J of each node [Pa]
    Eigen::VectorXd nodal_pressures(const Field &x) const;
    double mean_pressure(const Tetrahedron &tetrahedron, const Eigen::VectorXd &pressures) const;

    std::vector<Tetrahedron> tetrahedra_;
    std::vector<std::vector<int>> around_;      ///< (N) tetrahedra at each node
    Eigen::VectorXd node_volume_, node_lambda_; ///< (N)
};

} // namespace livermark::interactive
