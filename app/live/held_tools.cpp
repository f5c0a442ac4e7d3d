#include "app/live/scene.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numeric>
#include <utility>

#include "core/mesh/places.hpp"
#include "core/support/input_error.hpp"

namespace livermark::live {

Surface touchable_surface(const core::TetraMesh &mesh, const std::vector<bool> &is_constrained) {
    Surface surface;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f) {
        if (is_constrained[f])
            continue;
        const auto &nodes = mesh.boundary_triangles[f];
        surface.triangles.push_back(nodes);
        surface.facet.push_back(f);
        surface.area.push_back(core::area_vector(mesh, f).norm());
        surface.nodes.insert(surface.nodes.end(), nodes.begin(), nodes.end());
    }
    std::ranges::sort(surface.nodes);
    surface.nodes.erase(std::unique(surface.nodes.begin(), surface.nodes.end()), surface.nodes.end());
    return surface;
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
/// Steps between two searches for facets around the ball, which take as long as a third of a step on a liver.
constexpr int steps_between_looks = 8;
/// Depth of its centre below the surface at most, as a part of the radius, at which a ball has been pushed through: a
/// deeper one is beside a fold.
constexpr double pushed_through = 0.5;
/// Depth at most, as a part of the radius, in which a ball begins to touch that comes out of the body: what it gave at
/// once, the body would take as a blow.
constexpr double shallow = 0.25;
/// Moves that take a ball out of a dent, where other facets are near; a flat one needs one.
constexpr int most_moves = 4;
/// Difference of distances, over the radius, with which two triangles count as equally near.
constexpr double as_near = 1e-6;

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

/// Barycentric coordinates of a point in a triangle.
Vector3 coordinates_in(const core::Corners &corners, const Vector3 &point) {
    const Vector3 normal = normal_of(corners);
    const auto part = [&](const Vector3 &a, const Vector3 &b) {
        return (a - point).cross(b - point).dot(normal) / normal.squaredNorm();
    };
    return {part(corners[1], corners[2]), part(corners[2], corners[0]), part(corners[0], corners[1])};
}

/// Point of the surface that is nearest to another one.
struct NearestPoint {
    Vector3 point = Vector3::Zero();    ///< [m]
    double height = 0.0;                ///< of the other one above the surface [m]; negative below it
    Vector3 outwards = Vector3::Zero(); ///< from the surface to the outside, of length 1
};

/// @param triangles  one at least
NearestPoint nearest_point(const Surface &surface, const std::vector<int> &triangles, const PositionOf &position_of,
                           const Vector3 &to, double tolerance) {
    std::vector<std::pair<double, Vector3>> found; // distance, normal
    NearestPoint nearest;
    double least = std::numeric_limits<double>::infinity();
    for (const int t : triangles) {
        const auto corners = corners_of(surface, t, position_of);
        const Vector3 point = core::nearest_of_triangle(corners, to);
        const double distance = (point - to).norm();
        found.emplace_back(distance, normal_of(corners).normalized());
        if (distance < least) {
            least = distance;
            nearest.point = point;
        }
    }
    // At an edge or a node, the triangles around it tell together what is outside.
    Vector3 normal = Vector3::Zero();
    for (const auto &[distance, triangle_normal] : found)
        if (distance <= least + tolerance)
            normal += triangle_normal;
    const bool is_above = (to - nearest.point).dot(normal) > 0.0;
    nearest.height = is_above ? least : -least;
    nearest.outwards = is_above && least > tolerance ? Vector3((to - nearest.point) / least) : normal.normalized();
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

Disc disc_around(const Surface &surface, const std::vector<Vector3> &points, const Place &place, double radius) {
    Disc disc;
    disc.place = place;
    disc.shape = {place.point, radius};
    const auto at_rest = [&](int node) { return points[node]; };
    double sum = 0.0;
    for (const int t : all_triangles(surface)) {
        const auto corners = corners_of(surface, t, at_rest);
        const double reach = radius + longest_side(corners);
        if ((corners[0] - place.point).squaredNorm() >= reach * reach || normal_of(corners).dot(place.outwards) <= 0.0)
            continue;
        const auto moment = moments(disc.shape, corners, surface.area[t]);
        if (moment[0] == 0.0)
            continue;
        add_triangle(disc, surface, t, moment);
        sum += moment[0];
    }
    if (sum == 0.0) {
        const auto corners = corners_of(surface, place.triangle, at_rest);
        const Vector3 at = coordinates_in(corners, core::nearest_of_triangle(corners, place.point));
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

Load load_of(const Disc &disc, const Vector3 &force) {
    Load load{
        .nodes = disc.nodes, .triangles = disc.triangles, .total = force, .pressed = force.norm(), .shape = disc.shape};
    for (const double share : disc.share)
        load.facet.emplace_back(share * force);
    for (const double weight : disc.weight)
        load.nodal.emplace_back(weight * force);
    return load;
}

TouchableBody touchable_body(core::Body body, const std::vector<bool> &is_constrained,
                             const core::FacetSoftness &softness) {
    TouchableBody touchable{.body = std::move(body), .load_case = {}};
    auto &load_case = touchable.load_case;
    load_case.conditions.push_back({"held", core::ConditionKind::displacement});
    for (const bool is_held : is_constrained)
        load_case.condition_on.push_back(is_held ? 0 : -1);
    load_case.value.assign(is_constrained.size(), Vector3::Zero());
    load_case.touching.emplace();
    touchable.facets = core::touched_facets(touchable.body, load_case, softness);
    return touchable;
}

HeldBall HeldBall::copy() const {
    auto other = *this;
    if (contact)
        other.contact = std::make_shared<core::BallContact>(*contact);
    return other;
}

namespace {

/// Ball on some of the facets that can be touched.
HeldBall ball_on(const TouchableBody &touchable, const std::vector<core::TouchedFacet> &facets,
                 const core::ToolShape &shape, double friction) {
    auto load_case = touchable.load_case;
    // Points are as close as under a finger that presses half as deep as its radius.
    load_case.touching =
        core::TouchingTool{shape, Vector3::Zero(), 0.5 * shape.radius * Vector3::UnitX(), Vector3::Zero(), friction, 0};
    const int divisions = core::contact_divisions(touchable.body, load_case);
    return {.contact = std::make_shared<core::BallContact>(facets, divisions, shape, friction), .shape = shape};
}

} // namespace

HeldBall take_ball(const TouchableBody &touchable, const core::ToolShape &shape, double friction) {
    return ball_on(touchable, touchable.facets, shape, friction);
}

std::vector<HeldBall> take_jaws(const TouchableBody &touchable, const Surface &surface, const Jaws &jaws, double radius,
                                double friction) {
    std::vector<core::TouchedFacet> first, other; // of a body at rest as TouchingTool::is_for_other_jaw() has them
    for (std::size_t t = 0; t < touchable.facets.size(); ++t)
        (jaws.is_for_other[surface.facet[t]] ? other : first).push_back(touchable.facets[t]);
    return {ball_on(touchable, first, radius, friction), ball_on(touchable, other, radius, friction)};
}

core::ToolShape shape_of(const Tool &tool) {
    if (tool.face == core::ToolFace::ball)
        return tool.radius;
    return {tool.face, tool.radius, edge_of_plate * tool.radius, tool.inwards};
}

bool are_one_probe(const Tool &a, const Tool &b) {
    return a.kind == ToolKind::probe && b.kind == ToolKind::probe && a.friction == b.friction &&
           shape_of(a) == shape_of(b);
}

Vector3 outside(const Surface &surface, double radius, const Vector3 &centre, const PositionOf &position_of) {
    const auto all = all_triangles(surface);
    Vector3 place = centre;
    for (int move = 0; move < most_moves; ++move) {
        const auto nearest = nearest_point(surface, all, position_of, place, as_near * radius);
        if (nearest.height >= (1.0 - as_near) * radius || !nearest.outwards.allFinite())
            break;
        place = nearest.point + radius * nearest.outwards;
    }
    return place;
}

Vector3 before(const HeldBall &plate, const Vector3 &centre, const PositionOf &position_of) {
    const auto &shape = plate.shape;
    Vector3 place = centre;
    for (int move = 0; move < most_moves; ++move) {
        plate.contact->set_way(place, centre);
        plate.contact->look_around(position_of);
        double back = 0.0;
        plate.contact->visit_points([&](const std::array<int, 3> &nodes, const std::array<double, 3> &at,
                                        double /*compliance*/, const Vector3 & /*force*/) {
            Vector3 point = -place;
            for (std::size_t k = 0; k < 3; ++k)
                point += at[k] * position_of(nodes[k]);
            const double height = shape.axis.dot(point);
            // Far behind the face, a point that is beside the flat by s has the gap s - r to the flank.
            const double flank = core::gap_to(shape, point - (height + shape.reach()) * shape.axis).size;
            const double beside = std::max(0.0, flank + shape.radius);
            if (beside < shape.radius)
                back = std::max(back, std::sqrt(shape.radius * shape.radius - beside * beside) - height);
        });
        if (back <= as_near * shape.radius)
            break;
        place -= back * shape.axis;
    }
    if (!((place - centre).norm() <= shape.size + shape.radius))
        throw support::InputError("other parts of the body are in the way of a plate of this size there; take a "
                                  "smaller one or another place");
    return place;
}

namespace {

/// Triangles whose corners are all among some nodes, in ascending order.
std::vector<int> triangles_between(const Surface &surface, const std::vector<int> &nodes) {
    std::vector<int> found;
    for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t)
        if (std::ranges::all_of(surface.triangles[t],
                                [&](int node) { return std::ranges::binary_search(nodes, node); }))
            found.push_back(t);
    return found;
}

/// Looks for the facets that the ball may come to, how far it has sunk in below where they are at rest, and on which
/// side of them its centre is. What is behind the face of a plate is pushed on, so a plate is never below.
void look_around(HeldBall &ball, const Surface &surface, const Vector3 &centre, const PositionOf &position_of,
                 const PositionOf &at_rest) {
    ball.contact->look_around(position_of);
    if (ball.shape.is_plate())
        return ball.contact->set_circle(ball.shape.contact_radius(0.0));
    const auto near = triangles_between(surface, ball.contact->near());
    if (near.empty())
        return;
    const double radius = ball.shape.radius;
    const auto found_depth = [&] {
        return radius - nearest_point(surface, near, at_rest, centre, as_near * radius).height;
    };
    const double depth = ball.depth ? *ball.depth : found_depth();
    ball.contact->set_circle(ball.shape.contact_radius(std::max(0.0, depth)));
    const double height = nearest_point(surface, near, position_of, centre, as_near * radius).height;
    ball.is_below =
        ball.is_below ? height < (1.0 - shallow) * radius : height < 0.0 && height > -pushed_through * radius;
    if (ball.is_below)
        ball.contact->visit_points([](const auto &, const auto &, double, Vector3 &force) { force.setZero(); });
}

} // namespace

void lead(HeldBall &ball, const Surface &surface, const Proxy &proxy, const Vector3 &from, double time_step,
          const PositionOf &position_of, const PositionOf &at_rest) {
    if (--ball.steps_to_look < 0) {
        ball.steps_to_look = steps_between_looks - 1;
        ball.contact->set_way(from, proxy.position + steps_between_looks * time_step * proxy.velocity);
        look_around(ball, surface, proxy.position, position_of, at_rest);
    }
    ball.contact->set_way(from, proxy.position);
}

Load load_of(std::span<const HeldBall> balls, const Surface &surface) {
    Load load;
    const auto add = [](std::vector<int> &numbers, std::vector<Vector3> &forces, int number, const Vector3 &force) {
        const auto known = std::ranges::find(numbers, number) - numbers.begin();
        if (known == std::ssize(numbers)) {
            numbers.push_back(number);
            forces.emplace_back(Vector3::Zero());
        }
        forces[known] += force;
    };
    for (const auto &ball : balls) {
        int triangle = 0; // the contact visits its facets in their order
        ball.contact->visit_points([&](const std::array<int, 3> &nodes, const std::array<double, 3> &shape,
                                       double /*compliance*/, const Vector3 &force) {
            while (surface.triangles[triangle] != nodes)
                ++triangle;
            if (force.isZero(0.0))
                return;
            load.total += force;
            add(load.triangles, load.facet, triangle, force);
            for (std::size_t k = 0; k < 3; ++k)
                add(load.nodes, load.nodal, nodes[k], shape[k] * force);
        });
        load.pressed += ball.force().norm();
    }
    return load;
}

namespace {

/// Points of the way that are looked at whether they are inside.
constexpr int num_looks = 24;
/// Distance of the entry from the body at most, over the spread.
constexpr double off_surface = 0.25;

/// Written so that what is no number is outside.
void check_number(const char *what, double value, double least, double most) {
    if (!(value >= least && value <= most))
        throw support::InputError(
            fmt::format("a needle with {} {:g}; it has to be from {:g} to {:g} in SI units", what, value, least, most));
}

} // namespace

HeldNeedle::HeldNeedle(const core::Needle &needle, const core::TetraMesh &mesh, const core::Stepper &steps)
    : moving_(needle, mesh, steps.per_mass()), impulses_(moving_.num_places(), core::Vector3::Zero()) {
    moving_.begin(steps);
}

void HeldNeedle::act(core::Stepper &steps, double depth, double time_step) {
    const double most = fastest_needle * time_step;
    moving_.act(steps, moving_.depth() + std::clamp(depth - moving_.depth(), -most, most), time_step);
    force_ += time_step * moving_.force();
    tip_force_ += time_step * moving_.tip_force();
    moving_.add_impulses(impulses_);
    time_ += time_step;
}

NeedleReading HeldNeedle::reading(const core::Stepper &steps) {
    const bool has_moved = time_ > 0.0;
    NeedleReading reading{.depth = moving_.depth(),
                          .tip = moving_.tip(),
                          .force = has_moved ? force_ / time_ : moving_.force(),
                          .tip_force = has_moved ? tip_force_ / time_ : moving_.tip_force(),
                          .is_punctured = moving_.is_punctured(),
                          .target = moving_.target_displacement(steps),
                          .work = moving_.work(),
                          .forces = std::exchange(impulses_, {impulses_.size(), core::Vector3::Zero()})};
    for (auto &force : reading.forces)
        force = has_moved ? core::Vector3(force / time_) : core::Vector3::Zero();
    force_ = tip_force_ = time_ = 0.0;
    return reading;
}

bool are_one_needle(const Tool &a, const Tool &b) {
    const auto &m = a.needle, &n = b.needle;
    return a.kind == ToolKind::needle && b.kind == ToolKind::needle && m.entry == n.entry && m.target == n.target &&
           m.diameter == n.diameter && m.spread == n.spread && m.toughness == n.toughness && m.friction == n.friction &&
           m.puncture_force == n.puncture_force && m.side_stiffness == n.side_stiffness;
}

void check_depth(const Tool &tool) {
    if (tool.kind == ToolKind::needle)
        check_number("a depth of", tool.depth, -0.1, 0.5);
}

void check_needle(const Tool &tool, const core::TetraMesh &mesh, const std::vector<bool> &is_constrained_node) {
    if (tool.kind != ToolKind::needle)
        return;
    const auto &needle = tool.needle;
    if (!needle.entry.allFinite() || !needle.target.allFinite())
        throw support::InputError("a needle is led from or to a place that is none; choose both on the body");
    check_number("a diameter of", needle.diameter, 1e-4, 0.02);
    check_number("a spread of", needle.spread, 1e-3, 0.05);
    check_number("a toughness of", needle.toughness, 0.1, 1e5);
    check_number("friction of", needle.friction, 0.0, 1e4);
    check_number("a puncture force of", needle.puncture_force, needle.tip_force(), 100.0);
    const double length = needle.depth();
    if (!(length > needle.spread && length < 1.0))
        throw support::InputError(fmt::format("the target of a needle is {:.3g} m below its entry; it has to be deeper "
                                              "than the {:.3g} m over which forces are spread",
                                              length, needle.spread));
    const auto at_entry = core::locate(mesh, needle.entry);
    double held = 0.0; // how much of the entry's displacement is that of constrained nodes
    for (int k = 0; k < 4; ++k)
        held += is_constrained_node[mesh.tetrahedra[at_entry.tetrahedron][k]] ? at_entry.coordinates[k] : 0.0;
    if (held > 0.5)
        throw support::InputError("a needle enters where the body is constrained; choose another entry");
    const double first = std::min(1.0, off_surface * needle.spread / length);
    for (int i = 0; i <= num_looks; ++i) {
        const double part = first + (1.0 - first) * i / num_looks;
        const auto found = core::locate(mesh, needle.entry + part * (needle.target - needle.entry));
        if (!found.is_inside())
            throw support::InputError(fmt::format("the straight way of the needle leaves the body {:.3g} m below the "
                                                  "entry; choose another entry or target",
                                                  part * length));
    }
}

} // namespace livermark::live
