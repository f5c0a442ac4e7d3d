#include "load_cases/places/selector.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <numeric>
#include <utility>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "core/support/toml_input.hpp"
#include "core/units.hpp"

namespace livermark::load_cases {

namespace {

using core::Vector3;

/// Barycentric coordinates may be this far below zero: a ray through an edge goes through one facet at least.
constexpr double rounding_of_facets = 1e-9;

/// Distance along a ray [lengths of the direction] at which it goes through a facet from inside; nothing if it does
/// not. (Moeller and Trumbore 1997)
std::optional<double> crossing(const core::TetraMesh &mesh, int facet, const Vector3 &origin,
                               const Vector3 &direction) {
    const auto &[a, b, c] = mesh.boundary_triangles[facet];
    const Vector3 ab = mesh.points[b] - mesh.points[a];
    const Vector3 ac = mesh.points[c] - mesh.points[a];
    const double volume = ab.cross(ac).dot(direction);
    if (!(volume > 0.0))
        return std::nullopt;
    const Vector3 from_a = origin - mesh.points[a];
    const Vector3 side = from_a.cross(direction);
    const double v = -ac.dot(side) / volume;
    const double w = ab.dot(side) / volume;
    const double along = -from_a.dot(ab.cross(ac)) / volume;
    if (v < -rounding_of_facets || w < -rounding_of_facets || v + w > 1.0 + rounding_of_facets || along < 0.0)
        return std::nullopt;
    return along;
}

Vector3 nearest_of_facet(const core::TetraMesh &mesh, int facet, const Vector3 &point) {
    const auto &[a, b, c] = mesh.boundary_triangles[facet];
    return core::nearest_of_triangle({mesh.points[a], mesh.points[b], mesh.points[c]}, point);
}

} // namespace

std::vector<int> all_facets(const core::TetraMesh &mesh) {
    std::vector<int> facets(mesh.boundary_triangles.size());
    std::iota(facets.begin(), facets.end(), 0);
    return facets;
}

std::vector<int> facets_of_patch(const std::string &name, const toml::node &place, const core::TetraMesh &mesh) {
    const auto known = core::patches_of(mesh);
    if (std::ranges::find(known, name) == known.end())
        throw NotOnBody(support::place_of(place), fmt::format("the body has no patch '{}'", name),
                        fmt::format("it has {}; find_patches = true in the .toml of a liver finds those of livers",
                                    fmt::join(known, ", ")));
    return core::facets_in_patch(mesh, name);
}

Vector3 facet_centroid(const core::TetraMesh &mesh, int facet) {
    const auto &[a, b, c] = mesh.boundary_triangles[facet];
    return (mesh.points[a] + mesh.points[b] + mesh.points[c]) / 3.0;
}

double area_of(const std::vector<int> &facets, const core::TetraMesh &mesh) {
    double area = 0.0;
    for (const int f : facets)
        area += area_vector(mesh, f).norm();
    return area;
}

Vector3 middle_of(const std::vector<int> &facets, const core::TetraMesh &mesh) {
    Vector3 moment = Vector3::Zero();
    double area = 0.0;
    for (const int f : facets) {
        const double facet_area = area_vector(mesh, f).norm();
        moment += facet_area * facet_centroid(mesh, f);
        area += facet_area;
    }
    return moment / area;
}

SurfacePoint nearest_point(const std::vector<int> &facets, const core::TetraMesh &mesh, const Vector3 &point) {
    SurfacePoint nearest{facets.front(), nearest_of_facet(mesh, facets.front(), point)};
    for (const int f : facets)
        if (const Vector3 candidate = nearest_of_facet(mesh, f, point);
            (candidate - point).squaredNorm() < (nearest.point - point).squaredNorm())
            nearest = {f, candidate};
    return nearest;
}

SurfacePoint nearest_to_given(const toml::table &table, std::string_view key, const core::TetraMesh &mesh,
                              const Vector3 &point, double farthest) {
    const auto facets = all_facets(mesh);
    const auto from_surface = [&](const Vector3 &other) {
        return (nearest_point(facets, mesh, other).point - other).norm();
    };
    auto nearest = nearest_point(facets, mesh, point);
    const double away = (nearest.point - point).norm();
    if (away <= farthest)
        return nearest;
    std::string remedy = "give a point that is near the surface, in metres or in the 'unit' of the load case";
    // Whatever is divided by a thousand is near the origin, and that may be near the surface.
    const bool is_elsewhere = away > core::extent(mesh.points);
    for (const auto &[name, metres] : support::length_units) {
        if (metres == 1.0)
            continue;
        if (is_elsewhere && from_surface(metres * point) <= farthest) {
            remedy = fmt::format("give it in metres; or write unit = \"{0}\" in the load case, and all of its lengths "
                                 "in {0}",
                                 name);
            break;
        }
        if (from_surface(point / metres) <= farthest)
            remedy = fmt::format(
                "multiplied by {:g} it is near the surface: correct it, or the 'unit' of the load case", 1.0 / metres);
    }
    const auto shown = [](const Vector3 &p) { return fmt::format("({:.4g}, {:.4g}, {:.4g})", p.x(), p.y(), p.z()); };
    throw NotOnBody(support::place_of(*table.get(key)),
                    fmt::format("the '{}' {} m is {:.3g} m from the surface of the body, whose nearest point is {} m, "
                                "which is {} mm",
                                key, shown(point), away, shown(nearest.point),
                                shown(core::millimetres * nearest.point)),
                    remedy);
}

void refuse_beyond_body(const toml::table &table, std::string_view key, double length, const core::TetraMesh &mesh) {
    if (const double size = core::extent(mesh.points); length > size)
        throw NotOnBody(support::place_of(*table.get(key)),
                        fmt::format("the '{}' is {:.4g} m, and the body is {:.3g} m across", key, length, size),
                        "give it in metres; or write unit = \"mm\" in the load case, and all of its lengths in mm");
}

std::optional<SurfacePoint> exit_point(const core::TetraMesh &mesh, const Vector3 &origin, const Vector3 &direction,
                                       Exit which) {
    std::optional<SurfacePoint> chosen;
    double at = 0.0;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (const auto along = crossing(mesh, f, origin, direction);
            along && (!chosen || (which == Exit::first ? *along < at : *along > at))) {
            chosen = SurfacePoint{f, origin + *along * direction};
            at = *along;
        }
    return chosen;
}

core::Vector3 region_centroid(const std::string &name, const toml::node &place, const core::TetraMesh &mesh) {
    const auto region = std::ranges::find(mesh.region_names, name) - mesh.region_names.begin();
    if (region == std::ssize(mesh.region_names))
        throw NotOnBody(support::place_of(place), fmt::format("the body has no region '{}'", name),
                        fmt::format("it has {}", fmt::join(mesh.region_names, ", ")));
    const auto volumes = tetrahedron_volumes(mesh);
    core::Vector3 moment = core::Vector3::Zero();
    double volume = 0.0;
    for (int t = 0; t < mesh.num_tetrahedra(); ++t)
        if (mesh.region[t] == region) {
            for (const int node : mesh.tetrahedra[t])
                moment += 0.25 * volumes[t] * mesh.points[node];
            volume += volumes[t];
        }
    return moment / volume;
}

namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Part of the largest eigenvalue that is nothing: what is constrained at one facet of a large patch is far above,
/// rounding far below.
constexpr double rounding_of_balance = 1e-12;

/// Components of nodes that are constrained.
std::vector<std::array<bool, 3>> constrained_components(const core::TetraMesh &mesh, const core::LoadCase &load_case) {
    std::vector<std::array<bool, 3>> constrained(mesh.points.size(), {false, false, false});
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (load_case.is_constrained(f))
            for (const int node : mesh.boundary_triangles[f])
                for (int i = 0; i < 3; ++i)
                    if (!std::isnan(load_case.value[f][i]))
                        constrained[node][i] = true;
    return constrained;
}

std::string name_of_axis(const Vector3 &direction) {
    int axis = 0;
    const double largest = direction.cwiseAbs().maxCoeff(&axis);
    return largest > 0.999 * direction.norm()
               ? std::string(1, "xyz"[axis])
               : fmt::format("({:.2g}, {:.2g}, {:.2g})", direction.x(), direction.y(), direction.z());
}

} // namespace

void refuse_free_body(const core::TetraMesh &mesh, const core::LoadCase &load_case, const std::string &file) {
    const auto constrained = constrained_components(mesh, load_case);
    Vector3 centroid = Vector3::Zero();
    double num_constrained = 0.0;
    for (std::size_t n = 0; n < constrained.size(); ++n)
        for (const bool component : constrained[n])
            if (component) {
                centroid += mesh.points[n];
                ++num_constrained;
            }
    centroid /= num_constrained;
    double square = 0.0;
    for (std::size_t n = 0; n < constrained.size(); ++n)
        for (const bool component : constrained[n])
            square += component ? (mesh.points[n] - centroid).squaredNorm() : 0.0;
    const double radius = std::sqrt(square / num_constrained);
    Matrix6 gram = Matrix6::Zero();
    for (std::size_t n = 0; n < constrained.size(); ++n)
        for (int i = 0; i < 3; ++i)
            if (constrained[n][i]) {
                Vector6 row;
                row << Vector3::Unit(i), (mesh.points[n] - centroid).cross(Vector3::Unit(i)) / radius;
                gram += row * row.transpose();
            }
    const Eigen::SelfAdjointEigenSolver<Matrix6> motions(gram);
    if (motions.eigenvalues()[0] > rounding_of_balance * motions.eigenvalues()[5])
        return;
    // Of several free motions the solver may mix slides and turns; a slide is the easier one to say and to hold.
    for (int i = 0; i < 3; ++i)
        if (std::ranges::none_of(constrained, [=](const auto &components) { return components[i]; }))
            throw NotOnBody(
                file, fmt::format("the body as a whole can still slide along {}", "xyz"[i]),
                fmt::format("add a [[condition]] with a displacement that is not \"free\" in {}", "xyz"[i]));
    const Vector3 axis = motions.eigenvectors().col(0).tail<3>();
    throw NotOnBody(file, fmt::format("the body as a whole can still turn about {}", name_of_axis(axis)),
                    "add a [[condition]] with a displacement that prevents it");
}

namespace {

void refuse_empty(const Selection &selection, const toml::table &place) {
    if (selection.facets.empty())
        throw NotOnBody(support::place_of(place), fmt::format("no facet of the body is in '{}'", selection.name),
                        "choose another place or a larger one");
}

/// Mean pressure of the tool on a facet, over its pressure in the middle.
double pressure_on(const Selection &selection, const core::TetraMesh &mesh, int facet) {
    return selection.tool ? core::mean_height(*selection.tool, core::corners_of(mesh, facet)) : 1.0;
}

} // namespace

NotOnBody::NotOnBody(const std::string &where, std::string reason, const std::string &remedy)
    : support::InputError("{}: {}; {}", where, reason, remedy), reason_(std::move(reason)) {}

std::vector<double> load_shares(const Selection &selection, const core::TetraMesh &mesh) {
    std::vector<double> shares(mesh.boundary_triangles.size(), 0.0);
    double pressed_area = 0.0;
    for (const int f : selection.facets) {
        shares[f] = pressure_on(selection, mesh, f);
        pressed_area += shares[f] * area_vector(mesh, f).norm();
    }
    if (selection.area)
        for (double &share : shares)
            share *= *selection.area / pressed_area;
    return shares;
}

core::Vector3 pressed_normal(const Selection &selection, const core::TetraMesh &mesh) {
    core::Vector3 sum = core::Vector3::Zero();
    for (const int f : selection.facets)
        sum += pressure_on(selection, mesh, f) * area_vector(mesh, f);
    return sum / sum.norm();
}

bool is_round(const toml::table &place) {
    if (!place.contains("profile"))
        return false;
    const auto profile = support::required_string(place, "profile");
    if (profile != "round" && profile != "flat")
        support::refuse(*place.get("profile"), "there is no profile '{}'; a tool is \"round\" or \"flat\"", profile);
    return profile == "round";
}

std::vector<std::string_view> keys_with_place(std::initializer_list<std::string_view> own) {
    std::vector<std::string_view> keys(own);
    for (const auto &selector : all_selectors())
        keys.push_back(selector.name);
    return keys;
}

bool prescribes_displacement(const toml::table &condition) {
    return condition.contains("displacement") || condition.contains("push");
}

Selection select_facets(const toml::table &condition, const core::TetraMesh &mesh, const core::LoadCase &above) {
    const Selector *chosen = nullptr;
    int num_named = 0;
    std::vector<std::string> known;
    for (const auto &selector : all_selectors()) {
        known.push_back(selector.name);
        if (condition.contains(selector.name)) {
            chosen = &selector;
            ++num_named;
        }
    }
    if (num_named != 1)
        support::refuse(condition, "a condition applies to one of '{}'; give one of them", fmt::join(known, "', '"));
    auto selection = chosen->select(condition, mesh, above);
    refuse_empty(selection, condition);
    return selection;
}

std::vector<int> nodes_of(const std::vector<int> &facets, const core::TetraMesh &mesh) {
    std::vector<int> nodes;
    for (const int f : facets)
        nodes.insert(nodes.end(), mesh.boundary_triangles[f].begin(), mesh.boundary_triangles[f].end());
    std::ranges::sort(nodes);
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    return nodes;
}

int select_node(const toml::table &probe, const core::TetraMesh &mesh) {
    const auto name = support::required_string(probe, "patch");
    const Selection selection{name, facets_of_patch(name, *probe.get("patch"), mesh)};
    refuse_empty(selection, probe);
    const core::Vector3 middle = middle_of(selection.facets, mesh);
    int nearest = mesh.boundary_triangles[selection.facets.front()].front();
    for (const int f : selection.facets)
        for (const int node : mesh.boundary_triangles[f])
            if ((mesh.points[node] - middle).squaredNorm() < (mesh.points[nearest] - middle).squaredNorm())
                nearest = node;
    return nearest;
}

} // namespace livermark::load_cases
