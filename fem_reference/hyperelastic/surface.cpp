#include "fem_reference/hyperelastic/surface.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <map>
#include <numbers>
#include <stdexcept>
#include <string>

#include "core/mesh/tetra_mesh.hpp"
#include "fem_reference/solvers/two_level.hpp"

namespace livermark::hyperelastic {

using core::Vector3;

void SurfaceStiffness::add_to(fem_reference::SymmetricBlocks<double> &stiffness) const {
    for (const auto &facet : facets_)
        fem_reference::add_to(stiffness, facet.nodes, facet.symmetric);
}

void SurfaceStiffness::add_product(std::span<const double> x, std::span<double> out) const {
    for (const auto &facet : facets_) {
        const auto &nodes = facet.nodes;
        Eigen::VectorXd local(static_cast<Eigen::Index>(3 * nodes.size()));
        for (std::size_t a = 0; a < nodes.size(); ++a)
            local.segment<3>(static_cast<Eigen::Index>(3 * a)) = Vector3::Map(&x[3 * nodes[a]]);
        const Eigen::VectorXd product = facet.rest * local;
        for (std::size_t a = 0; a < nodes.size(); ++a)
            Vector3::Map(&out[3 * nodes[a]]) += product.segment<3>(static_cast<Eigen::Index>(3 * a));
    }
}

namespace {

using Tangents = Eigen::Matrix<double, 3, 2>;

/// x_r and x_s.
Tangents tangents(const fem_reference::ElasticSystem &system, const std::vector<int> &nodes,
                  const Eigen::Matrix2Xd &gradients, const std::vector<double> &displacement) {
    Tangents sum = Tangents::Zero();
    for (std::size_t a = 0; a < nodes.size(); ++a)
        sum += (system.points[nodes[a]] + Vector3::Map(&displacement[3 * nodes[a]])) * gradients.col(a).transpose();
    return sum;
}

/// The matrix of v -> a cross v.
Eigen::Matrix3d cross_matrix(const Vector3 &a) {
    Eigen::Matrix3d matrix;
    matrix << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
    return matrix;
}

} // namespace

FollowerPressure::FollowerPressure(const fem_reference::ElasticSystem &system, const core::TetraMesh &mesh,
                                   std::span<const double> pressure)
    : system_(&system), reference_(fem_reference::reference_triangle(system.nodes_per_facet == 3 ? 1 : 2)) {
    if (!pressure.empty() && pressure.size() != mesh.boundary_triangles.size())
        throw std::invalid_argument("follower pressures are given for " + std::to_string(pressure.size()) +
                                    " facets of " + std::to_string(mesh.boundary_triangles.size()));
    for (std::size_t f = 0; f < pressure.size(); ++f)
        if (pressure[f] < 0.0 || pressure[f] > 0.0)
            facets_.push_back({fem_reference::nodes_of_facet(system, mesh, f), pressure[f]});
}

void FollowerPressure::add_forces(double factor, const std::vector<double> &displacement,
                                  std::vector<double> &force) const {
    for (const auto &facet : facets_)
        for (std::size_t q = 0; q < reference_.weight.size(); ++q) {
            const Tangents x = tangents(*system_, facet.nodes, reference_.gradient[q], displacement);
            const Vector3 area = x.col(0).cross(x.col(1));
            for (std::size_t a = 0; a < facet.nodes.size(); ++a)
                Vector3::Map(&force[3 * facet.nodes[a]]) -=
                    factor * facet.pressure * reference_.weight[q] * reference_.shape[q][a] * area;
        }
}

SurfaceStiffness FollowerPressure::load_stiffness(double factor, const std::vector<double> &displacement) const {
    SurfaceStiffness result;
    for (const auto &facet : facets_) {
        const auto num_nodes = static_cast<Eigen::Index>(facet.nodes.size());
        Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(3 * num_nodes, 3 * num_nodes);
        for (std::size_t q = 0; q < reference_.weight.size(); ++q) {
            const auto &gradients = reference_.gradient[q];
            const Tangents x = tangents(*system_, facet.nodes, gradients, displacement);
            const Eigen::Matrix3d along_r = cross_matrix(x.col(0)), along_s = cross_matrix(x.col(1));
            const double weight = factor * facet.pressure * reference_.weight[q];
            for (Eigen::Index b = 0; b < num_nodes; ++b) {
                // The change of x_r cross x_s as node b moves.
                const Eigen::Matrix3d area_change = weight * (gradients(1, b) * along_r - gradients(0, b) * along_s);
                for (Eigen::Index a = 0; a < num_nodes; ++a)
                    matrix.block<3, 3>(3 * a, 3 * b) += reference_.shape[q][a] * area_change;
            }
        }
        result.add({facet.nodes, 0.5 * (matrix + matrix.transpose()), 0.5 * (matrix - matrix.transpose())});
    }
    return result;
}

namespace {

/// Over Young's modulus: more than any pressure below a ball that has not gone through the body.
constexpr double largest_pressure_over_modulus = 4.0;

double largest_modulus(const core::Body &body) {
    double modulus = 0.0;
    for (std::size_t t = 0; t < body.mesh.tetrahedra.size(); ++t)
        modulus = std::max(modulus, body.young_modulus_of(t));
    return modulus;
}

} // namespace

ContactSettings contact_settings(int degree, const core::ToolShape &shape) {
    ContactSettings settings;
    if (degree == 1 && !shape.is_plate()) {
        settings.softness = core::softness_of_tetrahedra;
        settings.max_augmentations = 0; // which would take back what facets give way by
    }
    return settings;
}

TouchingBall::TouchingBall(const fem_reference::ElasticSystem &system, const core::Body &body,
                           const core::LoadCase &load_case, const ContactSettings &settings)
    : system_(&system), tool_(load_case.touching.value()), settings_(settings),
      largest_pressure_(largest_pressure_over_modulus * largest_modulus(body)),
      reference_(fem_reference::reference_triangle(system.nodes_per_facet == 3 ? 1 : 2)) {
    const double stiff = settings.stiffness * largest_modulus(body) / tool_.contacts().front().radius;
    const auto all_touched = core::touched_facets(body, load_case, settings.softness.value_or(core::FacetSoftness{}));
    auto touched = all_touched.begin();
    for (int f = 0; f < body.mesh.num_boundary_triangles(); ++f)
        if (load_case.may_touch(f)) {
            const double penalty = settings.softness ? touched->penalty(0.0) : stiff;
            facets_.push_back({fem_reference::nodes_of_facet(system, body.mesh, static_cast<std::size_t>(f)),
                               touched->area,
                               tool_.is_for_other_jaw(touched->normal),
                               {penalty, penalty, tool_.friction}});
            ++touched;
        }
    memory_.resize(facets_.size() * reference_.weight.size());
    const std::vector<double> at_rest(3 * system.points.size(), 0.0);
    visit(tool_.start, at_rest, [&](std::size_t, std::size_t, double, std::size_t point, const Vector3 &from_centre) {
        memory_[point].anchor = from_centre;
    });
}

/// @param visit  (facet, point of the rule, area [m^2], number of the point, d [m])
template <class Visit>
void TouchingBall::visit(const Vector3 &centre, std::span<const double> displacement, const Visit &visit) const {
    constexpr double area_of_unit_triangle = 0.5;
    std::size_t point = 0;
    for (std::size_t f = 0; f < facets_.size(); ++f)
        for (std::size_t q = 0; q < reference_.weight.size(); ++q, ++point) {
            Vector3 from_centre = facets_[f].is_for_other_jaw ? -tool_.other_centre(centre) : -centre;
            for (std::size_t a = 0; a < facets_[f].nodes.size(); ++a) {
                const int node = facets_[f].nodes[a];
                from_centre +=
                    reference_.shape[q][static_cast<Eigen::Index>(a)] *
                    (system_->points[node] + Vector3::Map(&displacement[3 * static_cast<std::size_t>(node)]));
            }
            visit(f, q, facets_[f].area * reference_.weight[q] / area_of_unit_triangle, point, from_centre);
        }
}

void TouchingBall::add_forces(const Vector3 &centre, std::span<const double> displacement,
                              std::vector<double> &force) const {
    visit(centre, displacement,
          [&](std::size_t f, std::size_t q, double area, std::size_t point, const Vector3 &from_centre) {
              const auto contact = core::touch(facets_[f].law, tool_.shape, from_centre, memory_[point]);
              if (!contact.touches())
                  return;
              const Vector3 on_body = area * contact.traction();
              for (std::size_t a = 0; a < facets_[f].nodes.size(); ++a)
                  Vector3::Map(&force[3 * static_cast<std::size_t>(facets_[f].nodes[a])]) +=
                      reference_.shape[q][static_cast<Eigen::Index>(a)] * on_body;
          });
}

void TouchingBall::add_stiffness(const Vector3 &centre, std::span<const double> displacement,
                                 SurfaceStiffness &stiffness, std::span<const double> expected) const {
    SurfaceStiffness::OfFacet here;
    std::size_t facet = facets_.size();
    const auto keep = [&] {
        if (facet < facets_.size())
            stiffness.add(std::move(here));
    };
    visit(centre, displacement,
          [&](std::size_t f, std::size_t q, double area, std::size_t point, const Vector3 &from_centre) {
              auto contact = core::touch(facets_[f].law, tool_.shape, from_centre, memory_[point]);
              if (!contact.touches())
                  return;
              contact.pressure = std::min(contact.pressure, largest_pressure_);
              auto at_point =
                  core::contact_stiffness(facets_[f].law, tool_.shape, from_centre, memory_[point], contact);
              if (!expected.empty() && expected[point] < contact.pressure) {
                  at_point.rest += (contact.pressure - expected[point]) / contact.gap.distance *
                                   core::bend(tool_.shape, from_centre, contact.gap);
              }
              const auto num_nodes = static_cast<Eigen::Index>(facets_[f].nodes.size());
              if (f != facet) {
                  keep();
                  facet = f;
                  here = {facets_[f].nodes, Eigen::MatrixXd::Zero(3 * num_nodes, 3 * num_nodes),
                          Eigen::MatrixXd::Zero(3 * num_nodes, 3 * num_nodes)};
              }
              const auto &shape = reference_.shape[q];
              for (Eigen::Index a = 0; a < num_nodes; ++a)
                  for (Eigen::Index b = 0; b < num_nodes; ++b) {
                      const double weight = area * shape[a] * shape[b];
                      here.symmetric.block<3, 3>(3 * a, 3 * b) += weight * at_point.positive;
                      here.rest.block<3, 3>(3 * a, 3 * b) += weight * at_point.rest;
                  }
          });
    keep();
}

std::vector<double> TouchingBall::expected_pressure(const Vector3 &centre, std::span<const double> displacement,
                                                    std::span<const double> change) const {
    std::vector<double> expected(num_points(), 0.0);
    visit(
        centre, displacement, [&](std::size_t f, std::size_t q, double, std::size_t point, const Vector3 &from_centre) {
            const auto contact = core::touch(facets_[f].law, tool_.shape, from_centre, memory_[point]);
            if (!contact.touches())
                return;
            Vector3 moved = Vector3::Zero();
            for (std::size_t a = 0; a < facets_[f].nodes.size() && !change.empty(); ++a)
                moved += reference_.shape[q][static_cast<Eigen::Index>(a)] *
                         Vector3::Map(&change[3 * static_cast<std::size_t>(facets_[f].nodes[a])]);
            expected[point] = std::max(0.0, contact.pressure - facets_[f].law.penalty * contact.gap.normal.dot(moved));
        });
    return expected;
}

TouchSums TouchingBall::sums(const Vector3 &centre, std::span<const double> displacement) const {
    TouchSums sums;
    double normal_force = 0.0, second_moment = 0.0;
    const Vector3 axis = tool_.press.normalized();
    visit(centre, displacement,
          [&](std::size_t f, std::size_t, double area, std::size_t point, const Vector3 &from_centre) {
              const auto contact = core::touch(facets_[f].law, tool_.shape, from_centre, memory_[point]);
              if (!contact.touches())
                  return;
              const double force = area * contact.pressure;
              (facets_[f].is_for_other_jaw ? sums.other_force : sums.force) += area * contact.traction();
              sums.friction += area * contact.friction;
              sums.area += area;
              sums.slipping_area += contact.slips ? area : 0.0;
              sums.sunk_in += force * std::max(0.0, -contact.gap.size);
              normal_force += force;
              second_moment += force * (from_centre - axis.dot(from_centre) * axis).squaredNorm();
          });
    if (normal_force > 0.0) {
        sums.sunk_in /= normal_force;
        sums.radius = std::sqrt(2.5 * second_moment / normal_force);
    }
    return sums;
}

void TouchingBall::augment(const Vector3 &centre, std::span<const double> displacement) {
    if (settings_.max_augmentations == 0)
        return;
    visit(centre, displacement, [&](std::size_t f, std::size_t, double, std::size_t point, const Vector3 &from_centre) {
        memory_[point].multiplier = core::touch(facets_[f].law, tool_.shape, from_centre, memory_[point]).pressure;
    });
}

void TouchingBall::end_step(const Vector3 &centre, std::span<const double> displacement) {
    visit(centre, displacement, [&](std::size_t f, std::size_t, double, std::size_t point, const Vector3 &from_centre) {
        const auto contact = core::touch(facets_[f].law, tool_.shape, from_centre, memory_[point]);
        memory_[point] = core::after_step(facets_[f].law, from_centre, memory_[point], contact);
    });
}

namespace {

using Vector3 = Eigen::Vector3d;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// The matrix C_iJjL a_J b_L.
Matrix3 acoustic(const Tangent &tangent, const Vector3 &a, const Vector3 &b) {
    Matrix3 result = Matrix3::Zero();
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            for (int k = 0; k < 3; ++k)
                for (int l = 0; l < 3; ++l)
                    result(i, j) += tangent(3 * i + k, 3 * j + l) * a[k] * b[l];
    return result;
}

/// [S, H; -L, S^T] of Barnett and Lothe: the square root of -1 that has the invariant subspaces of a real matrix
/// without real eigenvalues, by Newton's method for the sign of a matrix.
/// @return not finite where there is none
Matrix6 root_of_minus_one(Matrix6 matrix) {
    constexpr int most_iterations = 40;
    constexpr double tolerance = 1e-11;
    for (int iteration = 0; iteration < most_iterations; ++iteration) {
        const Matrix6 next = 0.5 * (matrix - matrix.inverse());
        const double change = (next - matrix).norm();
        matrix = next;
        if (!(change > tolerance * matrix.norm()))
            return matrix;
    }
    return Matrix6::Constant(std::numeric_limits<double>::quiet_NaN());
}

/// Impedance of waves along one direction, of moduli over their size.
double least_eigenvalue(const Tangent &tangent, const Vector3 &along, const Vector3 &inwards) {
    const Matrix3 q = acoustic(tangent, along, along), r = acoustic(tangent, along, inwards);
    const Matrix3 inverse = acoustic(tangent, inwards, inwards).inverse();
    Matrix6 stroh; // A. N. Stroh 1962, Steady state problems in anisotropic elasticity, J. Math. Phys. 41
    stroh << -inverse * r.transpose(), inverse, r * inverse * r.transpose() - q, -r * inverse;
    const Matrix6 root = root_of_minus_one(stroh);
    if (!root.allFinite())
        return std::numeric_limits<double>::quiet_NaN();
    const Matrix3 inverse_h = root.topRightCorner<3, 3>().inverse();
    Eigen::Matrix3cd impedance;
    impedance.real() = inverse_h;
    impedance.imag() = inverse_h * root.topLeftCorner<3, 3>();
    return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3cd>(impedance, Eigen::EigenvaluesOnly).eigenvalues()[0];
}

} // namespace

Matrix3 whole_stress(const MaterialLaw &law, const core::Material &material, const Matrix3 &f) {
    const double jacobian = f.determinant();
    const auto volume = law.volume(jacobian);
    return law.stress(material, f) +
           law.volume_modulus(material) * volume.value * volume.slope * jacobian * f.inverse().transpose();
}

Tangent whole_tangent(const MaterialLaw &law, const core::Material &material, const Matrix3 &f) {
    const double jacobian = f.determinant(), modulus = law.volume_modulus(material);
    const auto volume = law.volume(jacobian);
    auto tangent = law.tangent(material, f);
    add_volume_tangent(modulus * volume.value * volume.slope,
                       modulus * (volume.slope * volume.slope + volume.value * volume.curvature), jacobian, f.inverse(),
                       tangent);
    return tangent;
}

double least_surface_impedance(const Tangent &tangent, const Vector3 &normal) {
    constexpr int num_directions = 12;
    const double size = tangent.diagonal().cwiseAbs().maxCoeff();
    const Vector3 first = normal.unitOrthogonal(), second = normal.cross(first);
    double least = std::numeric_limits<double>::infinity();
    for (int k = 0; k < num_directions; ++k) {
        const double angle = std::numbers::pi * k / num_directions; // -t has the conjugate impedance
        const double here =
            least_eigenvalue(tangent / size, std::cos(angle) * first + std::sin(angle) * second, -normal);
        if (!(here >= least))
            least = here;
        if (std::isnan(least))
            break;
    }
    return size * least;
}

namespace {

using Face = std::array<int, 3>; ///< nodes of the elements, ascending

constexpr int num_corners = 4, num_nodes = 10;

/// F where three barycentric coordinates are 1/3 and that of one corner is 0.
/// @param cell  (10) corners, then midpoints of 01 12 20 03 13 23
Matrix3 deformation_opposite(int corner, std::span<const int> cell, const std::vector<Vector3> &points,
                             std::span<const double> displacement) {
    Matrix3 edges;
    for (int k = 0; k < 3; ++k)
        edges.col(k) = points[cell[k + 1]] - points[cell[0]];
    const Matrix3 inverse = edges.inverse();
    std::array<Vector3, num_corners> slope; // of barycentric coordinates
    slope[0].setZero();
    for (int k = 0; k < 3; ++k) {
        slope[k + 1] = inverse.row(k);
        slope[0] -= slope[k + 1];
    }
    const auto value = [&](int k) { return k == corner ? 0.0 : 1.0 / 3.0; };
    const auto &ends = fem_reference::edges_of_quadratic;
    Matrix3 f = Matrix3::Identity();
    const auto add = [&](int node, const Vector3 &gradient) {
        f += Vector3::Map(&displacement[3 * static_cast<std::size_t>(cell[node])]) * gradient.transpose();
    };
    for (int k = 0; k < num_corners; ++k)
        add(k, (4.0 * value(k) - 1.0) * slope[k]);
    for (std::size_t e = 0; e < ends.size(); ++e) {
        const auto [a, b] = ends[e];
        add(num_corners + static_cast<int>(e), 4.0 * (value(a) * slope[b] + value(b) * slope[a]));
    }
    return f;
}

} // namespace

std::vector<SurfacePoint> surface_points(const Elements &elements, std::span<const double> displacement) {
    const auto &system = elements.system();
    const auto &mesh = elements.body().mesh;
    if (system.nodes_per_cell != num_nodes)
        throw std::invalid_argument("deformations of the surface are those of quadratic elements");
    std::map<Face, std::size_t> facet_of;
    for (std::size_t f = 0; f < mesh.boundary_triangles.size(); ++f) {
        Face face;
        std::ranges::transform(mesh.boundary_triangles[f], face.begin(),
                               [&](int node) { return system.mesh_node[node]; });
        facet_of[core::face_key(face)] = f;
    }
    std::vector<SurfacePoint> result(mesh.boundary_triangles.size());
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
        const auto cell = std::span(system.cell_nodes).subspan(t * num_nodes, num_nodes);
        for (int corner = 0; corner < num_corners; ++corner) {
            Face face;
            for (int k = 0, next = 0; k < num_corners; ++k)
                if (k != corner)
                    face[next++] = cell[k];
            face = core::face_key(face);
            const auto found = facet_of.find(face);
            if (found == facet_of.end())
                continue;
            auto &point = result[found->second];
            const Vector3 &a = system.points[face[0]], &b = system.points[face[1]], &c = system.points[face[2]];
            point.at_rest = (a + b + c) / 3.0;
            point.normal = (b - a).cross(c - a);
            point.area = 0.5 * point.normal.norm();
            point.normal /= 2.0 * point.area;
            if (point.normal.dot(system.points[cell[corner]] - a) > 0.0)
                point.normal = -point.normal;
            point.deformation = deformation_opposite(corner, cell, system.points, displacement);
            point.material = elements.body().material_of(t);
        }
    }
    return result;
}

Matrix3 under_traction(const MaterialLaw &law, const SurfacePoint &point, const Vector3 &traction) {
    const Vector3 &normal = point.normal, first = normal.unitOrthogonal(), second = normal.cross(first);
    const Vector3 spanned = (point.deformation * first).cross(point.deformation * second);
    const Matrix3 along = point.deformation - (point.deformation * normal) * normal.transpose();
    Vector3 across = spanned / spanned.squaredNorm(); // J = across . spanned = 1
    const auto with = [&](const Vector3 &column) { return Matrix3(along + column * normal.transpose()); };
    const auto out_of_balance = [&](const Vector3 &column) {
        return Vector3(whole_stress(law, point.material, with(column)) * normal - traction);
    };
    constexpr int most_iterations = 50;
    constexpr double tolerance = 1e-10, shortest = 1e-3;
    const double scale = point.material.shear_modulus();
    Vector3 residual = out_of_balance(across);
    for (int iteration = 0; iteration < most_iterations && residual.norm() > tolerance * scale; ++iteration) {
        const auto tangent = whole_tangent(law, point.material, with(across));
        Matrix3 slope = Matrix3::Zero();
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                slope(i, j) = normal.dot(tangent.block<3, 3>(3 * i, 3 * j) * normal);
        const Vector3 change = -slope.inverse() * residual;
        double part = 1.0;
        for (; part > shortest; part *= 0.5) {
            const Vector3 there = across + part * change;
            if (!(there.dot(spanned) > 0.0))
                continue;
            if (const Vector3 left = out_of_balance(there); left.norm() < residual.norm()) {
                across = there;
                residual = left;
                break;
            }
        }
        if (!(part > shortest))
            break;
    }
    if (!(residual.norm() <= tolerance * scale))
        return Matrix3::Constant(std::numeric_limits<double>::quiet_NaN());
    return with(across);
}

double unstable_part(const Elements &elements, const core::LoadCase &load_case, std::span<const double> displacement,
                     double factor) {
    const auto &law = elements.law();
    const auto surface = surface_points(elements, displacement);
    double unstable = 0.0, loaded = 0.0;
    for (int f = 0; f < load_case.num_facets(); ++f) {
        if (!load_case.is_loaded(f) || load_case.follows_surface(f))
            continue;
        const auto &point = surface[f];
        loaded += point.area;
        const Vector3 traction = load_case.value[f].array().isNaN().select(0.0, factor * load_case.value[f].array());
        const auto deformation = under_traction(law, point, traction);
        const bool is_stable =
            deformation.allFinite() &&
            least_surface_impedance(whole_tangent(law, point.material, deformation), point.normal) > 0.0;
        unstable += is_stable ? 0.0 : point.area;
    }
    return loaded > 0.0 ? unstable / loaded : 0.0;
}

} // namespace livermark::hyperelastic
