#pragma once

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "interactive/method.hpp"

namespace livermark::interactive {

using Matrix3 = Eigen::Matrix3d;

/// A linear tetrahedron at rest. Its deformation gradient is F = D B with D the edges from the first corner, by
/// columns.
struct Tetrahedron {
    std::array<int, 4> nodes;
    Matrix3 inverse_edges; ///< B, the inverse of the edges at rest [1/m]
    double volume;         ///< at rest [m^3]
    double mu, lambda;     ///< Lame parameters [Pa]

    Matrix3 gradient(const Field &x) const {
        Matrix3 edges;
        for (int c = 0; c < 3; ++c)
            edges.col(c) = x.col(nodes[c + 1]) - x.col(nodes[0]);
        return edges * inverse_edges;
    }

    /// Gradients of the four shape functions at rest, shape (4, 3) [1/m].
    Eigen::Matrix<double, 4, 3> shape_gradients() const {
        Eigen::Matrix<double, 4, 3> gradients;
        gradients.bottomRows<3>() = inverse_edges;
        gradients.row(0) = -inverse_edges.colwise().sum();
        return gradients;
    }

    /// f -= V P grad N [N], with P the first Piola-Kirchhoff stress [Pa].
    void add_forces(const Matrix3 &stress, Field &f) const {
        const Matrix3 forces = volume * stress * inverse_edges.transpose();
        f.col(nodes[0]) += forces.rowwise().sum();
        for (int c = 0; c < 3; ++c)
            f.col(nodes[c + 1]) -= forces.col(c);
    }
};

/// The tetrahedra of a body, in the order of its mesh.
std::vector<Tetrahedron> tetrahedra_at_rest(const core::Body &body);

/// d det F / dF, the matrix of cofactors.
inline Matrix3 cofactors(const Matrix3 &f) {
    Matrix3 result;
    result.col(0) = f.col(1).cross(f.col(2));
    result.col(1) = f.col(2).cross(f.col(0));
    result.col(2) = f.col(0).cross(f.col(1));
    return result;
}

} // namespace livermark::interactive

/// Energies per volume of a deformation gradient F: their value [Pa], the stress P = dW/dF [Pa], and the tangent dP/dF,
/// shape (9, 9), of F by columns.
namespace livermark::interactive::densities {

using Tangent = Eigen::Matrix<double, 9, 9>;

inline Eigen::Matrix<double, 9, 1> by_columns(const Matrix3 &a) {
    return Eigen::Map<const Eigen::Matrix<double, 9, 1>>(a.data());
}

/// d2 det F / dF2.
Tangent determinant_tangent(const Matrix3 &f);

/// The same tangent with its negative eigenvalues at zero.
Tangent semi_definite_part(const Tangent &tangent);

/// The rotation R of F = R S, that of the polar decomposition unless det F < 0: then the nearest one.
Matrix3 nearest_rotation(const Matrix3 &f);

/// The same by Newton's iteration R <- (R + R^-T) / 2 from R = F, which is quicker; what is flat or inside out is left
/// to the singular values.
/// (Higham 1986, SIAM J. Sci. Stat. Comput. 7(4))
inline Matrix3 rotation(const Matrix3 &f) {
    constexpr double tolerance = 1e-16; // of the square of a change; the next one changes its square
    constexpr int max_iterations = 12;
    if (f.determinant() > 0.05) {
        Matrix3 r = f;
        for (int i = 0; i < max_iterations; ++i) {
            const Matrix3 next = 0.5 * (r + cofactors(r) / r.determinant());
            const double change = (next - r).squaredNorm();
            r = next;
            if (change < tolerance)
                return r;
        }
    }
    return nearest_rotation(f);
}

/// W = mu |F - R|^2 + lambda / 2 tr(R^T F - 1)^2, whose forces are -R K (R^T x - x_0) with K the stiffness of linear
/// elasticity.
/// (Mueller, Gross 2004, Interactive virtual materials, Graphics Interface)
struct Corotational {
    double mu, lambda;

    double value(const Matrix3 &f) const {
        const Matrix3 r = rotation(f);
        const double trace = r.cwiseProduct(f).sum() - 3.0;
        return mu * (f - r).squaredNorm() + 0.5 * lambda * trace * trace;
    }
    Matrix3 stress(const Matrix3 &f) const { return stress(f, rotation(f)); }
    Matrix3 stress(const Matrix3 &f, const Matrix3 &r) const {
        return 2.0 * mu * (f - r) + lambda * (r.cwiseProduct(f).sum() - 3.0) * r;
    }
    /// dR = R [w], (tr S - S) w = axial vector of R^T dF.
    Tangent tangent(const Matrix3 &f) const;
};

/// W = mu / 2 (I1 - 3 - 2 ln J) + lambda / 2 (ln J)^2, infinite where J <= 0.
/// (Bonet, Wood 2008, Nonlinear Continuum Mechanics for Finite Element Analysis, eq. 6.27)
struct NeoHookean {
    double mu, lambda;

    double value(const Matrix3 &f) const {
        const double jacobian = f.determinant();
        if (!(jacobian > 0.0))
            return std::numeric_limits<double>::infinity();
        const double log = std::log(jacobian);
        return 0.5 * mu * (f.squaredNorm() - 3.0 - 2.0 * log) + 0.5 * lambda * log * log;
    }
    Matrix3 stress(const Matrix3 &f) const {
        const double jacobian = f.determinant();
        return mu * f + (lambda * std::log(jacobian) - mu) / jacobian * cofactors(f);
    }
    Tangent tangent(const Matrix3 &f) const;
};

/// W = mu / 2 (I1 - 3) - mu (J - 1) + (lambda + mu) / 2 (J - 1)^2, which goes through J = 0. The volume term has
/// lambda + mu, not lambda, so that small strains have the Lame parameters of the material.
/// (Smith, De Goes, Kim 2018, Stable neo-Hookean flesh simulation, ACM TOG 37(2), without its logarithm)
struct StableNeoHookean {
    double mu, lambda;

    double value(const Matrix3 &f) const {
        const double growth = f.determinant() - 1.0;
        return 0.5 * mu * (f.squaredNorm() - 3.0) - mu * growth + 0.5 * (lambda + mu) * growth * growth;
    }
    Matrix3 stress(const Matrix3 &f) const {
        return mu * f + ((lambda + mu) * (f.determinant() - 1.0) - mu) * cofactors(f);
    }
    Tangent tangent(const Matrix3 &f) const;
};

} // namespace livermark::interactive::densities

namespace livermark::interactive {

/// Adds V dN : dP/dF : dN of a tetrahedron.
void add_tangent(const Tetrahedron &tetrahedron, const densities::Tangent &tangent, Energy::Triplets &triplets);

/// W = sum over the tetrahedra of V times a density of energies.hpp.
template <class Density> class ElementEnergy : public Energy {
  public:
    explicit ElementEnergy(std::vector<Tetrahedron> tetrahedra) : tetrahedra_(std::move(tetrahedra)) {}

    double value(const Field &x) const override {
        double value = 0.0;
        for (const auto &t : tetrahedra_)
            value += t.volume * Density{t.mu, t.lambda}.value(t.gradient(x));
        return value;
    }

    void add_forces(const Field &x, Field &f) const override {
        for (const auto &t : tetrahedra_)
            t.add_forces(Density{t.mu, t.lambda}.stress(t.gradient(x)), f);
    }

    void add_hessian(const Field &x, bool is_projected, Triplets &triplets) const override {
        triplets.reserve(triplets.size() + 144 * tetrahedra_.size());
        for (const auto &t : tetrahedra_) {
            const densities::Tangent tangent = Density{t.mu, t.lambda}.tangent(t.gradient(x));
            add_tangent(t, is_projected ? densities::semi_definite_part(tangent) : tangent, triplets);
        }
    }

    const std::vector<Tetrahedron> &tetrahedra() const { return tetrahedra_; }

  private:
    std::vector<Tetrahedron> tetrahedra_;
};

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

namespace livermark::interactive::densities {

/// F = U diag(s) V^T with rotations U and V; the last of s is negative where det F is.
struct SignedSvd {
    Matrix3 u, v;
    core::Vector3 s;
};

SignedSvd signed_svd(const Matrix3 &f);

/// The point nearest to s whose components have the product one.
/// (Bouaziz et al. 2014, appendix A)
core::Vector3 nearest_of_unit_product(const core::Vector3 &s);

/// W = mu |F - R|^2 + 3 lambda / 2 |F - D|^2, with R the nearest rotation and D the nearest matrix of determinant one:
/// at small strains mu |eps|^2 + lambda / 2 (tr eps)^2, because |F - D|^2 is (tr eps)^2 / 3 there.
/// (Bouaziz et al. 2014, sections 5.1 and 5.2, with the weights 2 mu V and 3 lambda V)
struct Projective {
    double mu, lambda;

    double weight() const { return 2.0 * mu + 3.0 * lambda; } ///< of both
    double value(const Matrix3 &f) const;
    Matrix3 stress(const Matrix3 &f) const;
    Tangent tangent(const Matrix3 &f) const;
};

} // namespace livermark::interactive::densities

namespace livermark::interactive {

/// W = k / 2 (|d| - l)^2 of a spring whose ends are d apart.
struct StretchLaw {
    double stiffness;   ///< k [N/m]
    double rest_length; ///< l [m]

    double value(const core::Vector3 &d) const {
        const double stretch = d.norm() - rest_length;
        return 0.5 * stiffness * stretch * stretch;
    }
    /// dW/dd [N]
    core::Vector3 pull(const core::Vector3 &d) const { return stiffness * (1.0 - rest_length / d.norm()) * d; }
    /// d2W/dd2 [N/m]
    /// @param is_projected  whether it is made positive semidefinite, across a spring that is pressed
    Matrix3 tangent(const core::Vector3 &d, bool is_projected) const {
        const core::Vector3 along = d.normalized();
        double across = 1.0 - rest_length / d.norm();
        if (is_projected && across < 0.0)
            across = 0.0;
        return stiffness * (across * Matrix3::Identity() + (1.0 - across) * along * along.transpose());
    }
};

/// Springs on the edges of a mesh.
struct Springs {
    std::vector<std::array<int, 2>> edges; ///< (S) node numbers
    std::vector<double> stiffness;         ///< (S) [N/m]
    std::vector<double> rest_length;       ///< (S) [m]

    StretchLaw law(std::size_t s) const { return {stiffness[s], rest_length[s]}; }
};

/// Lloyd's formula, k = sum over the tetrahedra t at an edge of (2 sqrt 2 / 25) l_t E_t with l_t the edge of the
/// regular tetrahedron of equal volume, for springs with the shear modulus of the material: theirs is E_t / 2.5,
/// because central springs have Poisson's ratio 1/4, so E_t = 2.5 mu, and core::capsule_springs(). (Lloyd, Szekely,
/// Harders 2007, IEEE TVCG 13(5))
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
