#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/SparseCore>
#include <array>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "core/problem.hpp"
#include "msm/elastic_body.hpp"

namespace livermark::msm {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Matrix12 = Eigen::Matrix<double, 12, 12>;

/// Volume of a tetrahedron and its first derivatives.
struct VolumeGradient {
    double volume;                         ///< V [m^3], signed
    std::array<core::Vector3, 4> gradient; ///< dV/dx_a of the four corners [m^2]
};

/// Differences of a field, shape (3N), from corner 0 to the others.
inline std::array<core::Vector3, 3> spans_from_first(const Eigen::VectorXd &field,
                                                     const std::array<int, 4> &tetrahedron) {
    const core::Vector3 origin = node_part(field, tetrahedron[0]);
    return {node_part(field, tetrahedron[1]) - origin, node_part(field, tetrahedron[2]) - origin,
            node_part(field, tetrahedron[3]) - origin};
}

/// @param x            positions, 3 i + component for node i [m]
/// @param tetrahedron  node numbers
inline VolumeGradient volume_gradient(const Eigen::VectorXd &x, const std::array<int, 4> &tetrahedron) {
    const auto [a, b, c] = spans_from_first(x, tetrahedron);
    const core::Vector3 first = b.cross(c) / 6.0, second = c.cross(a) / 6.0, third = a.cross(b) / 6.0;
    return {.volume = a.dot(first), .gradient = {-(first + second + third), first, second, third}};
}

/// The derivative of the gradient along displacements u [m^2], if u is in m.
/// @param u  shape (3N) like x
inline std::array<core::Vector3, 4> volume_gradient_change(const Eigen::VectorXd &x, const Eigen::VectorXd &u,
                                                           const std::array<int, 4> &tetrahedron) {
    const auto [a, b, c] = spans_from_first(x, tetrahedron);
    const auto [p, q, r] = spans_from_first(u, tetrahedron);
    const core::Vector3 first = (q.cross(c) + b.cross(r)) / 6.0, second = (r.cross(a) + c.cross(p)) / 6.0,
                        third = (p.cross(b) + a.cross(q)) / 6.0;
    return {-(first + second + third), first, second, third};
}

/// Second derivatives d2V / dx_a dx_b, rows and columns 3 a + component [m].
Matrix12 volume_hessian(const Eigen::VectorXd &x, const std::array<int, 4> &tetrahedron);

/// Puts such a block of one tetrahedron where its nodes are in a (3N, 3N) matrix.
void add_block(std::vector<Eigen::Triplet<double>> &entries, const std::array<int, 4> &tetrahedron,
               const Matrix12 &block);

/// Square matrix that is the sum of these entries.
Eigen::SparseMatrix<double> square_matrix(const std::vector<Eigen::Triplet<double>> &entries, Eigen::Index size);

/// Sum of a block for each tetrahedron.
/// @param block_of  (number of the tetrahedron)
/// @return shape (size, size)
template <class Block>
Eigen::SparseMatrix<double> sum_of_blocks(const std::vector<std::array<int, 4>> &tetrahedra, Eigen::Index size,
                                          const Block &block_of) {
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(144 * tetrahedra.size());
    for (std::size_t t = 0; t < tetrahedra.size(); ++t)
        add_block(entries, tetrahedra[t], block_of(t));
    return square_matrix(entries, size);
}

// The strain of a tetrahedron in the lengths of its edges. Six edges are as many as a strain has components, so each
// says all that the other does. What is said of an edge, its stretch q_e in m^2, may be l^2 - l0^2, or, what is the
// same for small strains, 2 l0 (l - l0).

/// A vector for each of the six edges, from its first end to the second.
using EdgeVectors = std::array<core::Vector3, 6>;

/// Differences of a field along the edges.
EdgeVectors edge_spans(const std::array<int, 4> &nodes, const Eigen::VectorXd &field);

/// l_e^2 [m^2]
Vector6 squared_lengths(const EdgeVectors &spans);

/// The rates of stretches whose derivative by the span is 2 pull [m^2/s].
Vector6 stretch_rates(const EdgeVectors &pulls, const EdgeVectors &rates);

/// dq_e/dx of the four corners, rows 3 a + component [m]
Eigen::Matrix<double, 12, 6> stretch_slopes(const EdgeVectors &pulls);

/// Pulls the ends of each edge together with tension_e pull_e, tension_e = 2 dU/dq_e [N/m].
void add_tensions(const std::array<int, 4> &nodes, const EdgeVectors &pulls, const Vector6 &tension,
                  Eigen::VectorXd &force);

/// The second derivative of an energy of six spans that do not know of each other, each with its own.
/// @return shape (12, 12) [N/m]
Matrix12 hessian_of_edges(const std::array<Eigen::Matrix3d, 6> &second);

/// The matrix D of the strain E = D q, which is Green's where q = l^2 - l0^2, in the orthonormal components E11, E22,
/// E33, sqrt 2 E12, sqrt 2 E23 and sqrt 2 E31: with g the gradients of the barycentric coordinates at rest, E = -1/4
/// sum over edges ij of q_ij (g_i g_j^T + g_j g_i^T). (Delingette 2008, IEEE TVCG 14(2), for triangles)
/// @param rest   positions [m]
/// @param nodes  of a tetrahedron of positive volume
/// @return [1/m^2]
Matrix6 strain_of_stretches(const Eigen::VectorXd &rest, const std::array<int, 4> &nodes);

/// A symmetric tensor from these components, and back.
Eigen::Matrix3d tensor(const Vector6 &of);
Vector6 components(const Eigen::Matrix3d &of);

/// Stress lambda (tr E) I + 2 mu E in the same components, as a matrix that a strain is multiplied with [Pa].
Matrix6 isotropic_stiffness(double lame_lambda, double shear_modulus);

/// Stiffness at rest of linear elements of a material with a lambda that is no more than a few mu, near that of springs
/// around nodes: their shear stiffness is that of linear elements, but their volumes give way more easily. An element
/// has the energy 1/8 sum over its edges e, f of k_ef q_e q_f, k_ef = 4 V D_e : stiffness : D_f. (Delingette 2008, IEEE
/// TVCG 14(2), for triangles)
/// @param body  at rest, positive volumes
/// @param part  of the resistance to changes of shape that is left
/// @return shape (3N, 3N) [N/m]
Eigen::SparseMatrix<double> stiffness_of_softer_volume(const core::Body &body, double part);

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

struct SpringEnergy;

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

} // namespace livermark::msm
