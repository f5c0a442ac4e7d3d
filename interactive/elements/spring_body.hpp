#pragma once

#include <array>
#include <vector>

#include "interactive/elements/energies.hpp"

namespace livermark::interactive {

/// Springs on the edges of a mesh.
struct Springs {
    std::vector<std::array<int, 2>> edges; ///< (S) node numbers
    std::vector<double> stiffness;         ///< (S) [N/m]
    std::vector<double> rest_length;       ///< (S) [m]
};

/// Lloyd's formula, k = sum over the tetrahedra t at an edge of (2 sqrt 2 / 25) l_t E_t with l_t the edge of the
/// regular tetrahedron of equal volume, for springs with the shear modulus of the material: theirs is E_t / 2.5,
/// because central springs have Poisson's ratio 1/4, so E_t = 2.5 mu. (Lloyd, Szekely, Harders 2007, IEEE TVCG 13(5))
Springs springs_with_shear_modulus(const core::Body &body);

/// @param edges  of core::edge_table()
Springs springs_with_shear_modulus(const core::Body &body, const core::EdgeTable &edges);

/// W = sum over the springs of k / 2 (|x_a - x_b| - l)^2.
class SpringEnergy : public Energy {
  public:
    explicit SpringEnergy(Springs springs);

    double value(const Field &x) const override;
    void add_forces(const Field &x, Field &f) const override;
    void add_hessian(const Field &x, bool is_projected, Triplets &triplets) const override;

    const Springs &springs() const { return springs_; }

  private:
    Springs springs_;
};

namespace densities {

/// W = k / 2 (J - 1)^2 with k = lambda - mu, what springs that have mu, and so mu as their lambda too, lack of the
/// material; k = 0 below Poisson's ratio 1/4.
struct VolumeBesideSprings {
    double mu, lambda;

    double modulus() const { return lambda > mu ? lambda - mu : 0.0; }
    double value(const Matrix3 &f) const {
        const double growth = f.determinant() - 1.0;
        return 0.5 * modulus() * growth * growth;
    }
    Matrix3 stress(const Matrix3 &f) const { return modulus() * (f.determinant() - 1.0) * cofactors(f); }
    Tangent tangent(const Matrix3 &f) const {
        const Eigen::Matrix<double, 9, 1> c = by_columns(cofactors(f));
        return modulus() * (c * c.transpose() + (f.determinant() - 1.0) * determinant_tangent(f));
    }
};

} // namespace densities

/// Springs with the shear modulus of the material, and the volume of each tetrahedron.
class SpringAndVolumeEnergy : public Energy {
  public:
    /// @param edges  of core::edge_table()
    SpringAndVolumeEnergy(const core::Body &body, const core::EdgeTable &edges);

    double value(const Field &x) const override { return springs_.value(x) + volumes_.value(x); }
    void add_forces(const Field &x, Field &f) const override {
        springs_.add_forces(x, f);
        volumes_.add_forces(x, f);
    }
    void add_hessian(const Field &x, bool is_projected, Triplets &triplets) const override {
        springs_.add_hessian(x, is_projected, triplets);
        volumes_.add_hessian(x, is_projected, triplets);
    }

    const Springs &springs() const { return springs_.springs(); }
    const std::vector<Tetrahedron> &tetrahedra() const { return volumes_.tetrahedra(); }

  private:
    SpringEnergy springs_;
    ElementEnergy<densities::VolumeBesideSprings> volumes_;
};

} // namespace livermark::interactive
