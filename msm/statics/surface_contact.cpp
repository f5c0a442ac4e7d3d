#include "msm/statics/surface_contact.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/load_case.hpp"
#include "msm/springs/tetrahedron.hpp"

namespace livermark::msm {

SurfacePressure::SurfacePressure(const core::Problem &problem) {
    const auto &mesh = problem.body->mesh;
    const auto &load_case = problem.load_case;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (load_case.follows_surface(f)) {
            facets_.push_back({mesh.boundary_triangles[f], core::follower_pressure(load_case, mesh, f)});
            for (const int node : mesh.boundary_triangles[f])
                origin_ += mesh.points[node];
        }
    if (!facets_.empty())
        origin_ /= 3.0 * static_cast<double>(facets_.size());
}

double SurfacePressure::energy(const Field &positions) const {
    double energy = 0.0;
    for (const auto &[nodes, pressure] : facets_) {
        const core::Vector3 a = positions[nodes[0]] - origin_, b = positions[nodes[1]] - origin_;
        energy += pressure / 6.0 * a.cross(b).dot(positions[nodes[2]] - origin_);
    }
    return energy;
}

void SurfacePressure::add_gradient(const Field &positions, Field &gradient) const {
    for (const auto &[nodes, pressure] : facets_) {
        const core::Vector3 a = positions[nodes[0]] - origin_, b = positions[nodes[1]] - origin_,
                            c = positions[nodes[2]] - origin_;
        gradient[nodes[0]] += pressure / 6.0 * b.cross(c);
        gradient[nodes[1]] += pressure / 6.0 * c.cross(a);
        gradient[nodes[2]] += pressure / 6.0 * a.cross(b);
    }
}

Field SurfacePressure::rim_force(const Field &positions) const {
    auto result = force(positions);
    add_gradient(positions, result);
    return result;
}

Field SurfacePressure::force(const Field &positions) const {
    Field result(positions.size(), core::Vector3::Zero());
    for (const auto &[nodes, pressure] : facets_) {
        const core::Vector3 &a = positions[nodes[0]];
        const core::Vector3 area = 0.5 * (positions[nodes[1]] - a).cross(positions[nodes[2]] - a);
        for (const int node : nodes)
            result[node] -= pressure / 3.0 * area;
    }
    return result;
}

SurfaceContact::SurfaceContact(const core::Problem &problem, const core::FacetSoftness &softness)
    : num_nodes_(problem.body->mesh.points.size()) {
    if (!problem.load_case.touching)
        return;
    ball_ = *problem.load_case.touching;
    centre_ = ball_.start;
    shapes_ = core::facet_points(core::contact_divisions(*problem.body, problem.load_case));
    for (const auto &touched : core::touched_facets(*problem.body, problem.load_case, softness)) {
        const auto &facet =
            facets_.emplace_back(Facet{.touched = touched,
                                       .law = {touched.penalty(0.0), touched.tangential_penalty(), ball_.friction},
                                       .first = points_.size(),
                                       .is_for_other_jaw = ball_.is_for_other_jaw(touched.normal)});
        for (const auto &point : shapes_)
            points_.push_back(
                {.area = point.part * touched.area,
                 .memory = {.multiplier = 0.0, .anchor = from_centre(facet, point.shape, problem.body->mesh.points)}});
    }
}

void SurfaceContact::move_ball(double part) {
    centre_ = ball_.centre_at(part);
    const double circle = core::circle_of_contact(ball_, part);
    for (auto &facet : facets_)
        facet.law.penalty = facet.touched.penalty(circle);
}

core::Vector3 SurfaceContact::centre_for(const Facet &facet) const {
    return facet.is_for_other_jaw ? ball_.other_centre(centre_) : centre_;
}

core::Vector3 SurfaceContact::from_centre(const Facet &facet, const std::array<double, 3> &shape,
                                          const Field &positions) const {
    core::Vector3 point = -centre_for(facet);
    for (std::size_t k = 0; k < facet.touched.nodes.size(); ++k)
        point += shape[k] * positions[facet.touched.nodes[k]];
    return point;
}

/// Whether the ball may reach one of its points, or one of them is held by friction.
bool SurfaceContact::may_matter(const Facet &facet, const Field &positions) const {
    if (facet.remembers)
        return true;
    core::Vector3 middle = core::Vector3::Zero();
    for (const int node : facet.touched.nodes)
        middle += positions[node] / static_cast<double>(facet.touched.nodes.size());
    double extent = 0.0;
    for (const int node : facet.touched.nodes)
        extent = std::max(extent, (positions[node] - middle).norm());
    return !core::is_outside(ball_.shape, middle - centre_for(facet), extent);
}

/// @param visit  (facet, values of the shape functions, number of the point, d [m]) of all points that may matter
template <class Visit> void SurfaceContact::visit(const Field &positions, const Visit &visit) const {
    for (const auto &facet : facets_) {
        if (!may_matter(facet, positions))
            continue;
        for (std::size_t q = 0; q < shapes_.size(); ++q)
            visit(facet, shapes_[q].shape, facet.first + q, from_centre(facet, shapes_[q].shape, positions));
    }
}

/// Without its friction.
core::Contact SurfaceContact::normal_contact(const Facet &facet, const Point &point,
                                             const core::Vector3 &from_centre) const {
    auto frictionless = facet.law;
    frictionless.friction = 0.0;
    return core::touch(frictionless, ball_.shape, from_centre, point.memory);
}

SurfaceContact::Friction SurfaceContact::friction(const Facet &facet, const Point &point,
                                                  const core::Vector3 &from_centre) const {
    Friction friction;
    if (point.bound == 0.0)
        return friction;
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - point.normal * point.normal.transpose();
    const core::Vector3 slip = across * (from_centre - point.memory.anchor);
    const double size = slip.norm(), eps = facet.law.tangential_penalty;
    if (eps * size <= point.bound) {
        friction.energy = 0.5 * eps * size * size;
        friction.traction = -eps * slip;
        friction.stiffness = eps * across;
        return friction;
    }
    const core::Vector3 direction = slip / size;
    friction.energy = point.bound * size - 0.5 * point.bound * point.bound / eps;
    friction.traction = -point.bound * direction;
    friction.stiffness = point.bound / size * (across - direction * direction.transpose());
    return friction;
}

/// On the body [Pa].
core::Vector3 SurfaceContact::traction(const Facet &facet, const Point &point, const core::Vector3 &from_centre) const {
    return normal_contact(facet, point, from_centre).traction() + friction(facet, point, from_centre).traction;
}

double SurfaceContact::rounding_of_energy(const Field &positions) const {
    double force = 0.0;
    for (const auto &jaw_force : forces(positions))
        force += jaw_force.norm();
    return std::numeric_limits<double>::epsilon() * (ball_.shape.reach() + centre_.norm()) * force;
}

double SurfaceContact::energy(const Field &positions) const {
    double energy = 0.0;
    visit(positions, [&](const Facet &facet, const auto &, std::size_t number, const core::Vector3 &d) {
        const auto &point = points_[number];
        energy += point.area * (core::contact_energy(facet.law, normal_contact(facet, point, d), point.memory) +
                                friction(facet, point, d).energy);
    });
    return energy;
}

void SurfaceContact::add_gradient(const Field &positions, Field &gradient) const {
    visit(positions, [&](const Facet &facet, const auto &shape, std::size_t number, const core::Vector3 &d) {
        const core::Vector3 force = points_[number].area * traction(facet, points_[number], d);
        for (std::size_t k = 0; k < facet.touched.nodes.size(); ++k)
            gradient[facet.touched.nodes[k]] -= shape[k] * force;
    });
}

Eigen::Matrix3d SurfaceContact::stiffness(const Facet &facet, const Point &point, const core::Vector3 &from_centre,
                                          Tangent tangent) const {
    auto frictionless = facet.law;
    frictionless.friction = 0.0;
    const auto contact = normal_contact(facet, point, from_centre);
    const auto pressure = core::contact_stiffness(frictionless, ball_.shape, from_centre, point.memory, contact);
    const Eigen::Matrix3d normal = tangent == Tangent::exact ? pressure.all() : pressure.positive;
    return point.area * (normal + friction(facet, point, from_centre).stiffness);
}

/// Stiffness of the nodes of one facet.
SurfaceContact::Block SurfaceContact::block(const Facet &facet, const Field &positions, Tangent tangent) const {
    Block block = Block::Zero();
    if (!may_matter(facet, positions))
        return block;
    for (std::size_t q = 0; q < shapes_.size(); ++q) {
        const auto &shape = shapes_[q].shape;
        const auto point_stiffness =
            stiffness(facet, points_[facet.first + q], from_centre(facet, shape, positions), tangent);
        if (point_stiffness.isZero(0.0))
            continue;
        for (Eigen::Index a = 0; a < 3; ++a)
            for (Eigen::Index b = 0; b < 3; ++b)
                block.block<3, 3>(3 * a, 3 * b) +=
                    shape[static_cast<std::size_t>(a)] * shape[static_cast<std::size_t>(b)] * point_stiffness;
    }
    return block;
}

Eigen::SparseMatrix<double> SurfaceContact::hessian(const Field &positions, Tangent tangent) const {
    std::vector<Eigen::Triplet<double>> entries;
    for (const auto &facet : facets_) {
        const auto entries_of_facet = block(facet, positions, tangent);
        for (Eigen::Index r = 0; r < entries_of_facet.rows(); ++r)
            for (Eigen::Index c = 0; c < entries_of_facet.cols(); ++c)
                entries.emplace_back(3 * facet.touched.nodes[static_cast<std::size_t>(r / 3)] + r % 3,
                                     3 * facet.touched.nodes[static_cast<std::size_t>(c / 3)] + c % 3,
                                     entries_of_facet(r, c));
    }
    return square_matrix(entries, static_cast<Eigen::Index>(3 * num_nodes_));
}

void SurfaceContact::add_hessian_product(const Field &positions, const Eigen::VectorXd &u,
                                         Eigen::VectorXd &product) const {
    visit(positions, [&](const Facet &facet, const auto &shape, std::size_t number, const core::Vector3 &d) {
        core::Vector3 moved = core::Vector3::Zero();
        for (std::size_t k = 0; k < facet.touched.nodes.size(); ++k)
            moved += shape[k] * node_part(u, facet.touched.nodes[k]);
        const core::Vector3 force = stiffness(facet, points_[number], d, Tangent::exact) * moved;
        for (std::size_t k = 0; k < facet.touched.nodes.size(); ++k)
            node_part(product, facet.touched.nodes[k]) += shape[k] * force;
    });
}

double SurfaceContact::update(const Field &positions, double part) {
    double change = 0.0, all = 0.0;
    for (auto &facet : facets_) {
        if (!may_matter(facet, positions))
            continue;
        facet.remembers = false;
        for (std::size_t q = 0; q < shapes_.size(); ++q) {
            auto &point = points_[facet.first + q];
            const auto d = from_centre(facet, shapes_[q].shape, positions);
            const auto contact = normal_contact(facet, point, d);
            const core::Vector3 before = contact.traction() + friction(facet, point, d).traction;
            const double bound_was = point.bound;
            point.normal = contact.gap.normal;
            point.bound = facet.law.friction * contact.pressure;
            const core::Vector3 after = contact.traction() + friction(facet, point, d).traction;
            change += point.area * (after - before).norm();
            all += point.area * after.norm();
            point.bound = bound_was + part * (point.bound - bound_was);
            facet.remembers = facet.remembers || point.bound > 0.0;
        }
    }
    return all > 0.0 ? change / all : change > 0.0 ? 1.0 : 0.0;
}

void SurfaceContact::end_step(const Field &positions) {
    for (const auto &facet : facets_)
        for (std::size_t q = 0; q < shapes_.size(); ++q) {
            auto &memory = points_[facet.first + q].memory;
            const auto d = from_centre(facet, shapes_[q].shape, positions);
            memory = core::after_step(facet.law, d, memory, core::touch(facet.law, ball_.shape, d, memory));
        }
}

std::vector<core::Vector3> SurfaceContact::forces(const Field &positions) const {
    std::vector<core::Vector3> sums(ball_.between ? 2 : 1, core::Vector3::Zero());
    visit(positions, [&](const Facet &facet, const auto &, std::size_t number, const core::Vector3 &d) {
        sums[facet.is_for_other_jaw ? 1 : 0] += points_[number].area * traction(facet, points_[number], d);
    });
    return sums;
}

double SurfaceContact::depth(const Field &positions) const {
    double deepest = 0.0;
    for (const auto &facet : facets_)
        for (const auto &point : shapes_)
            deepest = std::max(deepest, -core::gap_to(ball_.shape, from_centre(facet, point.shape, positions)).size);
    return deepest;
}

} // namespace livermark::msm
