#include "fem_reference/hyperelastic/surface/touching_ball.hpp"

#include <algorithm>
#include <cmath>

namespace livermark::hyperelastic {

namespace {

using core::Vector3;

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
    law_.penalty = settings.stiffness * largest_modulus(body) / std::sqrt(tool_.radius * tool_.press.norm());
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
              const auto contact = core::touch(law_, tool_.radius, from_centre, memory_[point]);
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
              auto contact = core::touch(law_, tool_.radius, from_centre, memory_[point]);
              if (!contact.touches())
                  return;
              contact.pressure = std::min(contact.pressure, largest_pressure_);
              auto at_point = core::contact_stiffness(law_, from_centre, memory_[point], contact);
              if (!expected.empty() && expected[point] < contact.pressure) {
                  const auto &normal = contact.gap.normal;
                  at_point.rest += (contact.pressure - expected[point]) / from_centre.norm() *
                                   (Eigen::Matrix3d::Identity() - normal * normal.transpose());
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
              const auto contact = core::touch(law_, tool_.radius, from_centre, memory_[point]);
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
              const auto contact = core::touch(law_, tool_.radius, from_centre, memory_[point]);
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
        memory_[point].multiplier = core::touch(law_, tool_.radius, from_centre, memory_[point]).pressure;
    });
}

void TouchingBall::end_step(const Vector3 &centre, std::span<const double> displacement) {
    visit(centre, displacement, [&](std::size_t, std::size_t, double, std::size_t point, const Vector3 &from_centre) {
        const auto contact = core::touch(law_, tool_.radius, from_centre, memory_[point]);
        memory_[point] = core::after_step(law_, from_centre, memory_[point], contact);
    });
}

} // namespace livermark::hyperelastic
