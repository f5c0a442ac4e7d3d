#include "fem_reference/hyperelastic/surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace livermark::hyperelastic {

using core::Vector3;

std::vector<int> nodes_of_facet(const fem_reference::ElasticSystem &system, const core::TetraMesh &mesh,
                                std::size_t facet) {
    std::vector<int> nodes;
    for (const int corner : mesh.boundary_triangles[facet])
        nodes.push_back(system.mesh_node[corner]);
    const auto there =
        std::span(system.facet_nodes).subspan(facet * system.nodes_per_facet, system.nodes_per_facet).subspan(3);
    for (std::size_t k = 0; k < there.size(); ++k) {
        const Vector3 middle = 0.5 * (system.points[nodes[k]] + system.points[nodes[(k + 1) % 3]]);
        nodes.push_back(*std::ranges::min_element(
            there, {}, [&](int node) { return (system.points[node] - middle).squaredNorm(); }));
    }
    return nodes;
}

void SurfaceStiffness::add_to(fem_reference::SymmetricBlocks<double> &stiffness) const {
    const auto &rows = stiffness.rows;
    for (const auto &facet : of_facet_) {
        const auto &nodes = facet.nodes;
        for (std::size_t a = 0; a < nodes.size(); ++a)
            for (std::size_t b = 0; b < nodes.size(); ++b) {
                if (nodes[b] > nodes[a])
                    continue;
                const auto first = rows.column.begin() + rows.row_start[nodes[a]],
                           last = rows.column.begin() + rows.row_start[nodes[a] + 1];
                auto &block = a == b ? stiffness.diagonal[nodes[a]]
                                     : stiffness.below[std::lower_bound(first, last, nodes[b]) - rows.column.begin()];
                for (int i = 0; i < 3; ++i)
                    for (int j = 0; j < 3; ++j)
                        block[3 * i + j] +=
                            facet.symmetric(static_cast<Eigen::Index>(3 * a + i), static_cast<Eigen::Index>(3 * b + j));
            }
    }
}

void SurfaceStiffness::add_product(std::span<const double> x, std::span<double> out) const {
    for (const auto &facet : of_facet_) {
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
    : system_(&system), reference_(reference_triangle(system.nodes_per_facet == 3 ? 1 : 2)) {
    if (!pressure.empty() && pressure.size() != mesh.boundary_triangles.size())
        throw std::invalid_argument("follower pressures are given for " + std::to_string(pressure.size()) +
                                    " facets of " + std::to_string(mesh.boundary_triangles.size()));
    for (std::size_t f = 0; f < pressure.size(); ++f)
        if (pressure[f] < 0.0 || pressure[f] > 0.0)
            facets_.push_back({nodes_of_facet(system, mesh, f), pressure[f]});
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
                const Eigen::Matrix3d of_area = weight * (gradients(1, b) * along_r - gradients(0, b) * along_s);
                for (Eigen::Index a = 0; a < num_nodes; ++a)
                    matrix.block<3, 3>(3 * a, 3 * b) += reference_.shape[q][a] * of_area;
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
    for (const auto &material : body.materials)
        modulus = std::max(modulus, material.young_modulus);
    return modulus;
}

} // namespace

TouchingBall::TouchingBall(const fem_reference::ElasticSystem &system, const core::Body &body,
                           const core::LoadCase &load_case, const ContactSettings &settings)
    : system_(&system), tool_(load_case.touching.value()), settings_(settings),
      largest_pressure_(largest_pressure_over_modulus * largest_modulus(body)),
      reference_(reference_triangle(system.nodes_per_facet == 3 ? 1 : 2)) {
    law_.penalty = settings.stiffness * largest_modulus(body) / tool_.contact().radius;
    law_.tangential_penalty = law_.penalty;
    law_.friction = tool_.friction;
    for (int f = 0; f < body.mesh.num_boundary_triangles(); ++f)
        if (load_case.may_touch(f))
            facets_.push_back({nodes_of_facet(system, body.mesh, static_cast<std::size_t>(f)),
                               core::area_vector(body.mesh, f).norm()});
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
            Vector3 from_centre = -centre;
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
              const auto contact = core::touch(law_, tool_.shape, from_centre, memory_[point]);
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
              auto contact = core::touch(law_, tool_.shape, from_centre, memory_[point]);
              if (!contact.touches())
                  return;
              contact.pressure = std::min(contact.pressure, largest_pressure_);
              auto at_point = core::contact_stiffness(law_, tool_.shape, from_centre, memory_[point], contact);
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
    visit(centre, displacement,
          [&](std::size_t f, std::size_t q, double, std::size_t point, const Vector3 &from_centre) {
              const auto contact = core::touch(law_, tool_.shape, from_centre, memory_[point]);
              if (!contact.touches())
                  return;
              Vector3 moved = Vector3::Zero();
              for (std::size_t a = 0; a < facets_[f].nodes.size() && !change.empty(); ++a)
                  moved += reference_.shape[q][static_cast<Eigen::Index>(a)] *
                           Vector3::Map(&change[3 * static_cast<std::size_t>(facets_[f].nodes[a])]);
              expected[point] = std::max(0.0, contact.pressure - law_.penalty * contact.gap.normal.dot(moved));
          });
    return expected;
}

TouchSums TouchingBall::sums(const Vector3 &centre, std::span<const double> displacement) const {
    TouchSums sums;
    double normal_force = 0.0, second_moment = 0.0;
    const Vector3 axis = tool_.press.normalized();
    visit(centre, displacement,
          [&](std::size_t, std::size_t, double area, std::size_t point, const Vector3 &from_centre) {
              const auto contact = core::touch(law_, tool_.shape, from_centre, memory_[point]);
              if (!contact.touches())
                  return;
              const double force = area * contact.pressure;
              sums.force += area * contact.traction();
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
    visit(centre, displacement, [&](std::size_t, std::size_t, double, std::size_t point, const Vector3 &from_centre) {
        memory_[point].multiplier = core::touch(law_, tool_.shape, from_centre, memory_[point]).pressure;
    });
}

void TouchingBall::end_step(const Vector3 &centre, std::span<const double> displacement) {
    visit(centre, displacement, [&](std::size_t, std::size_t, double, std::size_t point, const Vector3 &from_centre) {
        const auto contact = core::touch(law_, tool_.shape, from_centre, memory_[point]);
        memory_[point] = core::after_step(law_, from_centre, memory_[point], contact);
    });
}

} // namespace livermark::hyperelastic
