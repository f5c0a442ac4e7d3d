#pragma once

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <array>

#include "core/mesh/tetra_mesh.hpp"
#include "msm/elastic_body.hpp"
#include "msm/spring_energy.hpp"
#include "msm/springs/edge_stretches.hpp"

/// What of the deformation of a tetrahedron coupled springs average, as vectors m that means are taken of, and what a
/// mean resists with. Each measure has
///   of(x)                          m of the tetrahedron at positions x
///   rate(x, u)                     its derivative along u
///   slope(x)                       dm/dx of the four corners, shape (size, 12), columns 3 a + component
///   add_force(x, stress, force)    force -= slope^T stress
///   add_turning(x, u, stress, f)   f -= the derivative of slope along u, transposed, times stress
///   curvature(x, stress, tangent)  sum of stress_k d2m_k/dx2, shape (12, 12), without what the tangent leaves out
/// and, of a mean m,
///   energy(energy, mu, m), stress(...) and stiffness(..., tangent), the derivatives by m.
/// Stresses are times a volume where slopes make forces of them.
namespace livermark::msm {

using Matrix12 = Eigen::Matrix<double, 12, 12>;

/// Without what is negative.
template <class Matrix> Matrix semi_definite_part(const Matrix &matrix) {
    const Eigen::SelfAdjointEigenSolver<Matrix> eigen(matrix);
    return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() * eigen.eigenvectors().transpose();
}

/// What measures of strains resist with: m are the components of E, see edge_stretches.hpp.
struct StrainOfMean {
    static constexpr int size = 6;
    using Value = Vector6;
    using Stiffness = Matrix6;

    static double energy(const SpringEnergy &energy, double mu, const Value &strain) {
        return energy.energy(mu, tensor(strain));
    }
    static Value stress(const SpringEnergy &energy, double mu, const Value &strain) {
        return components(energy.stress(mu, tensor(strain)));
    }
    static Stiffness stiffness(const SpringEnergy &energy, double mu, const Value &strain, Tangent tangent);
};

/// What both measures of lengths know of a tetrahedron.
class StrainOfEdges : public StrainOfMean {
  protected:
    StrainOfEdges(const std::array<int, 4> &nodes, const Eigen::VectorXd &rest)
        : nodes_(nodes), strain_of_stretch_(strain_of_stretches(rest, nodes)) {}

    /// 2 dU/dq of each edge [N/m], of a stress times a volume.
    Vector6 tensions(const Value &stress) const { return 2.0 * (strain_of_stretch_.transpose() * stress); }

    std::array<int, 4> nodes_;
    Matrix6 strain_of_stretch_; // [1/m^2]
};

/// StrainMeasure::cauchy_green
class SquaredLengths : public StrainOfEdges {
  public:
    SquaredLengths(const std::array<int, 4> &nodes, const Eigen::VectorXd &rest);

    Value of(const Eigen::VectorXd &x) const;
    Value rate(const Eigen::VectorXd &x, const Eigen::VectorXd &u) const;
    Eigen::Matrix<double, 6, 12> slope(const Eigen::VectorXd &x) const;
    void add_force(const Eigen::VectorXd &x, const Value &stress, Eigen::VectorXd &force) const;
    void add_turning(const Eigen::VectorXd &x, const Eigen::VectorXd &u, const Value &stress,
                     Eigen::VectorXd &force) const;
    Matrix12 curvature(const Eigen::VectorXd &x, const Value &stress, Tangent tangent) const;

  private:
    Vector6 rest_square_; // l0^2 of each edge [m^2]
};

/// StrainMeasure::elongation
class Elongations : public StrainOfEdges {
  public:
    Elongations(const std::array<int, 4> &nodes, const Eigen::VectorXd &rest);

    Value of(const Eigen::VectorXd &x) const;
    Value rate(const Eigen::VectorXd &x, const Eigen::VectorXd &u) const;
    Eigen::Matrix<double, 6, 12> slope(const Eigen::VectorXd &x) const;
    void add_force(const Eigen::VectorXd &x, const Value &stress, Eigen::VectorXd &force) const;
    void add_turning(const Eigen::VectorXd &x, const Eigen::VectorXd &u, const Value &stress,
                     Eigen::VectorXd &force) const;
    Matrix12 curvature(const Eigen::VectorXd &x, const Value &stress, Tangent tangent) const;

  private:
    /// The edges as they are: how long [m], and which way, times l0 [m].
    struct Edges {
        Vector6 length;
        EdgeVectors pull;
    };
    Edges edges(const Eigen::VectorXd &x) const;

    Vector6 rest_length_; // l0 of each edge [m]
};

/// StrainMeasure::deformation_gradient: m is F - I, column after column, so that small strains keep all their digits.
class Gradients {
  public:
    static constexpr int size = 9;
    using Value = Eigen::Matrix<double, 9, 1>;
    using Stiffness = Eigen::Matrix<double, 9, 9>;

    Gradients(const std::array<int, 4> &nodes, const Eigen::VectorXd &rest);

    Value of(const Eigen::VectorXd &x) const;
    Value rate(const Eigen::VectorXd &x, const Eigen::VectorXd &u) const;
    Eigen::Matrix<double, 9, 12> slope(const Eigen::VectorXd &x) const;
    void add_force(const Eigen::VectorXd &x, const Value &stress, Eigen::VectorXd &force) const;
    /// F is linear in positions.
    void add_turning(const Eigen::VectorXd & /*x*/, const Eigen::VectorXd & /*u*/, const Value & /*stress*/,
                     Eigen::VectorXd & /*force*/) const {}
    Matrix12 curvature(const Eigen::VectorXd & /*x*/, const Value & /*stress*/, Tangent /*tangent*/) const {
        return Matrix12::Zero();
    }

    static double energy(const SpringEnergy &energy, double mu, const Value &mean);
    static Value stress(const SpringEnergy &energy, double mu, const Value &mean);
    static Stiffness stiffness(const SpringEnergy &energy, double mu, const Value &mean, Tangent tangent);

  private:
    std::array<int, 4> nodes_;
    std::array<core::Vector3, 4> rest_;     // corners [m]
    std::array<core::Vector3, 4> gradient_; // of the barycentric coordinates at rest [1/m]
};

} // namespace livermark::msm
