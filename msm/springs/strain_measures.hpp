#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "msm/elastic_body.hpp"
#include "msm/spring_energy.hpp"
#include "msm/springs/coupled_springs.hpp"
#include "msm/springs/tetrahedron.hpp"

namespace livermark::msm {

// Measures of the deformation of a tetrahedron, as vectors m that coupled springs take means of, and what a
// mean resists with. Each measure has
//   of(x)                          m of the tetrahedron at positions x
//   rate(x, u)                     its derivative along u
//   slope(x)                       dm/dx of the four corners, shape (size, 12), columns 3 a + component
//   add_force(x, stress, force)    force -= slope^T stress
//   add_turning(x, u, stress, f)   f -= the derivative of slope along u, transposed, times stress
//   curvature(x, stress, tangent)  sum of stress_k d2m_k/dx2, shape (12, 12), without what the tangent leaves out
// and, of a mean m,
//   energy(law, m), stress(...) and stiffness(..., tangent), the derivatives by m,
//   strain(m)                      E, of which the energy is one
//   push(m, s)                     the stress by m that a second Piola-Kirchhoff stress is
// Stresses are times a volume where slopes make forces of them.

using Matrix12 = Eigen::Matrix<double, 12, 12>;

/// Law of a mean: W_s without what has faded of its isochoric part, and beside that a stress of its own.
struct MeanLaw {
    const SpringEnergy &spring_energy;
    double mu;                       ///< [Pa]
    double part = 1.0;               ///< of the isochoric part of W_s that is left
    Vector6 added = Vector6::Zero(); ///< second Piola-Kirchhoff stress beside that, in components [Pa]

    double energy(const Eigen::Matrix3d &strain) const;
    Eigen::Matrix3d stress(const Eigen::Matrix3d &strain) const;
    Matrix6 stiffness(const Eigen::Matrix3d &strain) const;
    /// At rest, without what is added.
    Matrix6 stiffness_at_rest() const;
};

/// Response of measures of strains: m are the components of E, see tetrahedron.hpp.
struct StrainOfMean {
    static constexpr int size = 6;
    using Value = Vector6;
    using Stiffness = Matrix6;

    static double energy(const MeanLaw &law, const Value &strain) { return law.energy(tensor(strain)); }
    static Value stress(const MeanLaw &law, const Value &strain) { return components(law.stress(tensor(strain))); }
    static Stiffness stiffness(const MeanLaw &law, const Value &strain, Tangent tangent);
    static Eigen::Matrix3d strain(const Value &strain) { return tensor(strain); }
    static Value push(const Value & /*strain*/, const Vector6 &stress) { return stress; }
};

/// Data that both measures of lengths have of a tetrahedron.
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

    static double energy(const MeanLaw &law, const Value &mean);
    static Value stress(const MeanLaw &law, const Value &mean);
    static Stiffness stiffness(const MeanLaw &law, const Value &mean, Tangent tangent);
    static Eigen::Matrix3d strain(const Value &mean);
    static Value push(const Value &mean, const Vector6 &stress);

  private:
    std::array<int, 4> nodes_;
    std::array<core::Vector3, 4> rest_;     // corners [m]
    std::array<core::Vector3, 4> gradient_; // of the barycentric coordinates at rest [1/m]
};

/// The parts of a body over which coupled springs take means of strains, of all kinds behind each other: around nodes,
/// around edges, and tetrahedra. Kinds without weight are left out. Where two materials meet stress jumps, so each has
/// parts of its own.
struct MeanParts {
    /// A part with some of a tetrahedron.
    struct Member {
        int part;
        double of_tetrahedron; ///< share of the tetrahedron that belongs to the part, times the weight of its kind
        double in_mean;        ///< weight of the tetrahedron in the mean: its volume in the part over that of the part
    };

    std::vector<double> volume;  ///< (C) at rest, times the weight of their kind [m^3]
    std::vector<double> modulus; ///< (C) shear modulus [Pa]
    std::vector<Member> members; ///< of each tetrahedron behind each other
    std::vector<int> start;      ///< (M + 1) where these begin

    int num_parts() const { return static_cast<int>(volume.size()); }
};

/// @param body  at rest, positive volumes
MeanParts mean_parts(const core::Body &body, const StrainDomains &domains);

} // namespace livermark::msm
