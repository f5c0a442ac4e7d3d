#include "app/live/contact.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace livermark::live {

Surface touchable_surface(const core::TetraMesh &mesh, const std::vector<bool> &is_constrained) {
    Surface surface;
    surface.nodal_area.assign(mesh.points.size(), 0.0);
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f) {
        if (is_constrained[f])
            continue;
        const double area = core::area_vector(mesh, f).norm();
        surface.triangles.push_back(mesh.boundary_triangles[f]);
        surface.facet.push_back(f);
        surface.area.push_back(area);
        for (const int node : mesh.boundary_triangles[f])
            surface.nodal_area[node] += area / 3.0;
    }
    for (int node = 0; node < mesh.num_nodes(); ++node)
        if (surface.nodal_area[node] > 0.0)
            surface.nodes.push_back(node);
    return surface;
}

Load no_load(const Surface &surface) {
    Load load;
    load.nodal.assign(surface.nodal_area.size(), core::Vector3::Zero());
    load.facet.assign(surface.triangles.size(), core::Vector3::Zero());
    return load;
}

void clear(Load &load) {
    for (const int node : load.nodes)
        load.nodal[node].setZero();
    for (const int triangle : load.triangles)
        load.facet[triangle].setZero();
    load.nodes.clear();
    load.triangles.clear();
    load.total.setZero();
}

namespace {

/// The coupling comes to rest without swinging.
const double coupling_damping = 2.0 * std::sqrt(coupling_stiffness * coupling_mass);

core::Vector3 shortened(const core::Vector3 &vector, double longest) {
    const double length = vector.norm();
    return length > longest ? core::Vector3(longest / length * vector) : vector;
}

} // namespace

void follow(Proxy &proxy, const core::Vector3 &target, double time_step) {
    proxy.target += shortened(target - proxy.target, fastest_target * time_step);
}

void advance(Proxy &proxy, const core::Vector3 &force, double time_step) {
    const core::Vector3 drawn = shortened(coupling_stiffness * (proxy.target - proxy.position), strongest_coupling);
    proxy.velocity += time_step / coupling_mass * (drawn - coupling_damping * proxy.velocity + force);
    proxy.position += time_step * proxy.velocity;
}

namespace {

using core::Vector3;

/// Parts of the radius that the parts of a triangle are at most large, over which a round load is summed.
constexpr double part_of_radius = 0.1;
/// A disc stays where it is until its middle is off by so many parts of its radius.
constexpr double off_middle = 1e-5;
/// How often the nearest point of the surface is searched for while nothing is touched.
constexpr int misses_between_searches = 8;
constexpr double search_margin = 0.008; ///< [m]
/// How deep in the surface a sphere is at most that begins to touch it on its way, as a part of its radius and in
/// metres.
constexpr double shallow = 0.25, least_shallow = 0.002;
/// Cosine of the angle by which a disc may have turned since it was at rest: the normal of a dent that a sphere is in
/// tells nothing, so that the force has the direction of the normal at rest.
constexpr double most_turned = 0.5;

core::Corners corners_of(const Surface &surface, int triangle, const PositionOf &position_of) {
    const auto &[a, b, c] = surface.triangles[triangle];
    return {position_of(a), position_of(b), position_of(c)};
}

Vector3 normal_of(const core::Corners &corners) {
    return (corners[1] - corners[0]).cross(corners[2] - corners[0]);
}

double longest_side(const core::Corners &corners) {
    const auto &[a, b, c] = corners;
    return std::sqrt(std::max({(a - b).squaredNorm(), (b - c).squaredNorm(), (c - a).squaredNorm()}));
}

/// Barycentric coordinates of the point of a triangle that is nearest to a point.
/// (C. Ericson, Real-Time Collision Detection, 2005, section 5.1.5)
Vector3 nearest_in(const core::Corners &corners, const Vector3 &point) {
    const auto &[a, b, c] = corners;
    const Vector3 ab = b - a, ac = c - a;
    const double d1 = ab.dot(point - a), d2 = ac.dot(point - a), d3 = ab.dot(point - b), d4 = ac.dot(point - b),
                 d5 = ab.dot(point - c), d6 = ac.dot(point - c);
    const double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
    if (d1 <= 0.0 && d2 <= 0.0)
        return {1.0, 0.0, 0.0};
    if (d3 >= 0.0 && d4 <= d3)
        return {0.0, 1.0, 0.0};
    if (d6 >= 0.0 && d5 <= d6)
        return {0.0, 0.0, 1.0};
    if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0)
        return {1.0 - d1 / (d1 - d3), d1 / (d1 - d3), 0.0};
    if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0)
        return {1.0 - d2 / (d2 - d6), 0.0, d2 / (d2 - d6)};
    if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) {
        const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return {0.0, 1.0 - w, w};
    }
    const double sum = va + vb + vc;
    return {va / sum, vb / sum, vc / sum};
}

/// The point at rest whose place now is nearest to a point.
/// @param facing  triangles whose normals at rest look away from this are left out; zero for none
/// @return on no triangle if nothing is near, as where a motion is lost
Place nearest_place(const Surface &surface, const std::vector<Vector3> &points, const std::vector<int> &triangles,
                    const Vector3 &facing, const PositionOf &position_of, const Vector3 &point) {
    const auto at_rest = [&](int node) { return points[node]; };
    Place nearest;
    double least = std::numeric_limits<double>::infinity();
    for (const int t : triangles) {
        const auto rest = corners_of(surface, t, at_rest);
        const Vector3 normal = normal_of(rest);
        if (!facing.isZero(0.0) && normal.dot(facing) <= 0.0)
            continue;
        const auto now = corners_of(surface, t, position_of);
        const Vector3 share = nearest_in(now, point);
        const double square = (core::point_at(now, share) - point).squaredNorm();
        if (square < least) {
            least = square;
            nearest = {.point = core::point_at(rest, share), .outwards = normal, .triangle = t};
        }
    }
    return nearest;
}

/// Calls visit(barycentric coordinates) for the centroid of each of rows^2 equal parts of a triangle.
template <class Visit> void visit_parts(int rows, Visit visit) {
    const auto part = [&](double i, double j) { visit(Vector3(rows - i - j, i, j) / rows); };
    for (int i = 0; i < rows; ++i)
        for (int j = 0; i + j < rows; ++j) {
            part(i + 1.0 / 3.0, j + 1.0 / 3.0);
            if (i + j + 1 < rows)
                part(i + 2.0 / 3.0, j + 2.0 / 3.0);
        }
}

/// Integral of h over a triangle, and of h times the linear shape functions [m^2].
std::array<double, 4> moments(const core::RoundLoad &load, const core::Corners &corners, double area) {
    const double rows = std::ceil(longest_side(corners) / (part_of_radius * load.radius));
    const int num_rows = static_cast<int>(std::clamp(rows, 1.0, static_cast<double>(core::triangle_rows)));
    const double part = area / (num_rows * num_rows);
    std::array<double, 4> sums{};
    visit_parts(num_rows, [&](const Vector3 &at) {
        const double pressed = part * load.height(core::point_at(corners, at));
        sums[0] += pressed;
        for (std::size_t k = 0; k < 3; ++k)
            sums[k + 1] += pressed * at[static_cast<Eigen::Index>(k)];
    });
    return sums;
}

void add_triangle(Disc &disc, const Surface &surface, int triangle, const std::array<double, 4> &moment) {
    disc.triangles.push_back(triangle);
    disc.share.push_back(moment[0]);
    for (std::size_t k = 0; k < 3; ++k) {
        const int node = surface.triangles[triangle][k];
        const auto known = std::ranges::find(disc.nodes, node) - disc.nodes.begin();
        if (known == std::ssize(disc.nodes)) {
            disc.nodes.push_back(node);
            disc.weight.push_back(0.0);
        }
        disc.weight[known] += moment[k + 1];
    }
}

std::vector<int> all_triangles(const Surface &surface) {
    std::vector<int> all(surface.triangles.size());
    std::iota(all.begin(), all.end(), 0);
    return all;
}

/// Puts the disc around another place.
void move_disc(SphereContact &contact, const Surface &surface, const std::vector<Vector3> &points, const Place &place,
               double radius) {
    if (place.triangle < 0)
        return;
    if (contact.near.empty() || (place.point - contact.near_point).norm() > search_margin) {
        contact.near = triangles_around(surface, points, place.point, radius, search_margin);
        contact.near_point = place.point;
    }
    contact.disc = disc_around(surface, points, contact.near, place, radius);
}

} // namespace

Place place_of_node(const Surface &surface, const std::vector<Vector3> &points, int node) {
    Place place{.point = points[node]};
    for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t)
        if (std::ranges::find(surface.triangles[t], node) != surface.triangles[t].end()) {
            place.triangle = t;
            place.outwards += normal_of(corners_of(surface, t, [&](int i) { return points[i]; }));
        }
    return place;
}

std::vector<int> triangles_around(const Surface &surface, const std::vector<Vector3> &points, const Vector3 &point,
                                  double radius, double margin) {
    std::vector<int> found;
    for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
        const auto corners = corners_of(surface, t, [&](int i) { return points[i]; });
        const double reach = radius + margin + longest_side(corners);
        if ((corners[0] - point).squaredNorm() < reach * reach)
            found.push_back(t);
    }
    return found;
}

Disc disc_around(const Surface &surface, const std::vector<Vector3> &points, const std::vector<int> &near,
                 const Place &place, double radius) {
    Disc disc;
    disc.place = place;
    disc.shape = {place.point, radius};
    const auto at_rest = [&](int node) { return points[node]; };
    double sum = 0.0;
    for (const int t : near) {
        const auto corners = corners_of(surface, t, at_rest);
        if (normal_of(corners).dot(place.outwards) <= 0.0)
            continue;
        const auto moment = moments(disc.shape, corners, surface.area[t]);
        if (moment[0] == 0.0)
            continue;
        add_triangle(disc, surface, t, moment);
        sum += moment[0];
    }
    if (sum == 0.0) {
        const auto corners = corners_of(surface, place.triangle, at_rest);
        const Vector3 at = nearest_in(corners, place.point);
        add_triangle(disc, surface, place.triangle, {1.0, at[0], at[1], at[2]});
        sum = 1.0;
    }
    for (auto *list : {&disc.share, &disc.weight})
        for (double &value : *list)
            value /= sum;
    return disc;
}

Vector3 mean_over(const Disc &disc, const PositionOf &field) {
    Vector3 mean = Vector3::Zero();
    for (std::size_t k = 0; k < disc.nodes.size(); ++k)
        mean += disc.weight[k] * field(disc.nodes[k]);
    return mean;
}

Vector3 mean_normal(const Disc &disc, const Surface &surface, const PositionOf &position_of) {
    Vector3 sum = Vector3::Zero();
    for (std::size_t k = 0; k < disc.triangles.size(); ++k) {
        const int t = disc.triangles[k];
        sum += disc.share[k] / surface.area[t] * normal_of(corners_of(surface, t, position_of));
    }
    return sum.normalized();
}

void put_force(const Disc &disc, const Vector3 &force, Load &load) {
    clear(load);
    load.triangles = disc.triangles;
    for (std::size_t k = 0; k < disc.triangles.size(); ++k)
        load.facet[disc.triangles[k]] = disc.share[k] * force;
    load.nodes = disc.nodes;
    for (std::size_t k = 0; k < disc.nodes.size(); ++k)
        load.nodal[disc.nodes[k]] = disc.weight[k] * force;
    load.total = force;
    load.shape = disc.shape;
}

Vector3 penetration(SphereContact &contact, const Surface &surface, const std::vector<Vector3> &points,
                    const Sphere &sphere, double tracking, const PositionOf &displacement_of) {
    auto &disc = contact.disc;
    const auto position_of = [&](int node) -> Vector3 { return points[node] + displacement_of(node); };
    if (!contact.touches && contact.num_misses % misses_between_searches == 0) {
        const auto place =
            nearest_place(surface, points, all_triangles(surface), Vector3::Zero(), position_of, sphere.centre);
        move_disc(contact, surface, points, place, sphere.radius);
    }
    const auto to_centre = [&]() -> Vector3 {
        return sphere.centre - disc.place.point - mean_over(disc, displacement_of);
    };
    const auto at_rest = [&](int node) { return points[node]; };
    const Vector3 normal = mean_normal(disc, surface, at_rest);
    const double turned = normal.dot(mean_normal(disc, surface, position_of));
    const auto along = [&](const Vector3 &way) -> Vector3 { return way - way.dot(normal) * normal; };
    const Vector3 way = contact.touches ? Vector3(sphere.centre - contact.last_centre) : Vector3::Zero();
    const Vector3 aside = along(to_centre()), shift = along(way) + tracking * (aside - along(way));
    if (aside.norm() > off_middle * sphere.radius)
        move_disc(contact, surface, points,
                  nearest_place(surface, points, contact.near, disc.place.outwards, at_rest, disc.place.point + shift),
                  sphere.radius);
    contact.last_centre = sphere.centre;
    const Vector3 from_surface = to_centre();
    const double height = from_surface.dot(normal);
    const double off_square = (from_surface - height * normal).squaredNorm(),
                 radius_square = sphere.radius * sphere.radius;
    // What touches already is driven out also where its centre has got below the surface, as under a body in motion.
    // What does not touch begins to where it is shallow: a body that swings would gain energy of a sphere in it.
    const double depth = off_square < radius_square ? std::sqrt(radius_square - off_square) - height : 0.0;
    const bool is_taken_up = !contact.touches && contact.num_misses == 0;
    const bool may_begin = height > 0.0 && (is_taken_up || depth < std::max(shallow * sphere.radius, least_shallow));
    if (is_taken_up)
        contact.first_depth = std::max(depth, 0.0);
    else if (!contact.touches)
        contact.first_depth = 0.0;
    contact.touches =
        depth > 0.0 && depth < 2.0 * sphere.radius && turned > most_turned && (contact.touches || may_begin);
    contact.num_misses = contact.touches ? 0 : contact.num_misses + 1;
    if (!contact.touches)
        return Vector3::Zero();
    return -depth * normal;
}

} // namespace livermark::live
