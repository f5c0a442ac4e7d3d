#pragma once

#include <Eigen/SparseCore>
#include <vector>

#include "interactive/scene.hpp"

namespace livermark::interactive {

/// The elastic energy behind a method: what its static solution minimises.
class Energy {
  public:
    using Triplets = std::vector<Eigen::Triplet<double>>;

    Energy() = default;
    virtual ~Energy() = default;
    Energy(const Energy &) = delete;
    Energy &operator=(const Energy &) = delete;

    /// @param x  positions, here and below
    /// @return W(x) [J]; infinity where it is not defined, as in tetrahedra that are inside out
    virtual double value(const Field &x) const = 0;

    /// f -= dW/dx [N].
    virtual void add_forces(const Field &x, Field &f) const = 0;

    /// Adds d2W/dx2 [N/m], unknown 3 i + c for component c of node i, both triangles.
    /// @param is_projected  whether that of each element is made positive semidefinite
    virtual void add_hessian(const Field &x, bool is_projected, Triplets &triplets) const = 0;
};

} // namespace livermark::interactive
