#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "core/events.hpp"
#include "core/mesh/tetra_mesh.hpp"

namespace livermark::core {

/// Spread of the traction of a round tool: as h(x) = sqrt(1 - |x - m|^2 / a^2), and nothing beyond its rim.
/// (Hertz's contact; K. L. Johnson, Contact Mechanics, 1985, equation 3.39)
struct RoundLoad {
    Vector3 middle = Vector3::Zero(); ///< m [m]
    double radius = 0.0;              ///< a [m], > 0

    /// h at a point, from 0 to 1.
    double height(const Vector3 &point) const;
    bool operator==(const RoundLoad &) const = default;
};

using Corners = std::array<Vector3, 3>; ///< of a triangle [m]

Corners corners_of(const TetraMesh &mesh, int facet);

/// The point of a triangle with these barycentric coordinates [m].
Vector3 point_at(const Corners &corners, const Vector3 &barycentric);

/// Mean of h over a triangle.
double mean_height(const RoundLoad &load, const Corners &corners);

constexpr int triangle_rows = 24; ///< of parts of a triangle, so that of a share at the rim a thousandth is left
constexpr int num_triangle_parts = triangle_rows * triangle_rows;

/// Calls visit(barycentric coordinates of the centroid) for each of the num_triangle_parts parts of a triangle, which
/// are all alike.
template <class Visit> void visit_triangle_parts(Visit visit) {
    const auto part = [&](double i, double j) { visit(Vector3(triangle_rows - i - j, i, j) / triangle_rows); };
    for (int i = 0; i < triangle_rows; ++i)
        for (int j = 0; i + j < triangle_rows; ++j) {
            part(i + 1.0 / 3.0, j + 1.0 / 3.0);
            if (i + j + 1 < triangle_rows)
                part(i + 2.0 / 3.0, j + 2.0 / 3.0);
        }
}

/// Parts of the force on a triangle that its three corners take with linear shape functions; their sum is 1.
/// @param load  nullptr where the traction is the same everywhere
std::array<double, 3> linear_parts(const RoundLoad *load, const Corners &corners);

/// The same with quadratic shape functions: the corners, then the middles of the sides 01, 12 and 20. Where the
/// traction is the same everywhere, the corners take nothing.
std::array<double, 6> quadratic_parts(const RoundLoad *load, const Corners &corners);

/// Means of the traction over the parts of a triangle, over its mean in the whole one: areas times these have the area
/// as their sum.
/// @param load  nullptr where the traction is the same everywhere, and all are 1
std::vector<double> shares_of_parts(const RoundLoad *load, std::span<const Corners> parts);

/// Effect of a condition on the facets of its place.
enum class ConditionKind : std::uint8_t {
    displacement, ///< prescribes components of it
    traction,     ///< a given one, which keeps its direction
    pressure,     ///< stays perpendicular to the surface and acts on its area as that moves; its value is the traction
                  ///< at rest, which linear models take
    press,        ///< tractions that all are multiplied by one number until the body has moved by LoadCase::press_depth
    touch         ///< what LoadCase::touching exerts; it has no facets, because contact finds them
};

/// Condition on one place. LoadCase has its facets, and what each of them prescribes.
struct Condition {
    std::string place; ///< its name
    ConditionKind kind = ConditionKind::displacement;
    std::optional<RoundLoad> round{}; ///< how a traction is spread, whose values are then means over facets; or evenly

    bool is_traction() const {
        return kind == ConditionKind::traction || kind == ConditionKind::pressure || kind == ConditionKind::press;
    }
    bool is_given_load() const { return kind == ConditionKind::traction || kind == ConditionKind::pressure; }
    /// Whether the force on the place is a result: it holds, presses or is touched.
    bool is_constraint() const { return !is_given_load(); }
    bool operator==(const Condition &) const = default;
};

/// Regime of a load case: how far it goes, and so which reference judges it. Results of one are never put beside those
/// of the other.
enum class Regime : std::uint8_t {
    small, ///< as linear elasticity has it
    large  ///< deformations of surgical size, along a path of loads, judged by hyperelasticity
};

/// The word for a regime in load cases, tables and result files.
const char *to_string(Regime regime);

/// A place that gave up facets to the places above it in the load case, because the body is narrow there.
struct YieldedPlace {
    std::string name;
    double lost_area = 0.0; ///< part of the area of all its facets, above 0
};

/// A load case put on a mesh: everything lives on boundary triangles or in the volume, never on single nodes, so that
/// it means the same for linear and quadratic elements and for springs.
struct LoadCase : Events {
    std::string name;                      ///< file stem
    std::string title;                     ///< one line that a surgeon or engineer recognises
    std::string definition;                ///< the TOML text
    Regime regime = Regime::small;         ///< what judges it
    double target_peak_displacement = 0.0; ///< what the load is meant to reach [m]
    bool scale_to_target = false;          ///< whether the loads are to be multiplied until the baseline reaches it
    double load_scale = 1.0;               ///< what they have been multiplied by so far

    std::vector<Condition> conditions; ///< (C) in the order of the file: an earlier one has a node that two share
    std::vector<int> condition_on;     ///< (T) index into conditions, -1 where the surface is free
    std::vector<Vector3> value;        ///< (T) displacement [m] or traction [Pa]; NaN = component is free
    /// (N) what prescribed displacements are multiplied by at each node of the mesh, linear along edges: how a round
    /// tool sinks in. Empty where all are as the value says.
    std::vector<double> node_factor;
    /// (N) what is added to prescribed displacements at each node of the mesh, linear along edges: how a place moved
    /// that was measured [m]. Free components stay free. Empty where nothing is added.
    std::vector<Vector3> node_shift;
    Vector3 acceleration = Vector3::Zero(); ///< body force per mass [m/s^2]
    /// Depth to which the places that press move the body: the displacement along their tractions, in the mean weighted
    /// with these, which all are multiplied by one number for it [m]. 0 where none presses. Nothing else drives the
    /// body then, and the tractions are written as together they make one newton [Pa/N].
    double press_depth = 0.0;
    std::vector<YieldedPlace> yielded; ///< (Y) none where all places are apart by themselves
    /// (L) parts of the loads at which solutions are kept, ascending to 1; all that drives the body grows with them.
    /// Empty in the small regime, and where slow_history says how all grows.
    std::vector<double> path;

    EventSet kinds() const; ///< of the events that happen
    /// Whether time passes after the static start or in the material.
    bool in_time() const;
    bool is_touched() const;                       ///< whether an event touches the body
    std::vector<ExpectedContact> contacts() const; ///< of that event, first that of its first tool
    double contact_depth() const;                  ///< to which that presses [m]; 0 where none touches

    /// Parts of the loads at the points of the way of a solution.
    const std::vector<double> &load_parts() const { return slow_history ? slow_history->factors : path; }
    /// Number of points of the way of a solution: Solution::path where it ended well.
    std::size_t num_path_points() const { return load_parts().size(); }

    /// Factor of a prescribed displacement at a node of the mesh.
    double factor_at(int node) const { return node_factor.empty() ? 1.0 : node_factor[node]; }
    /// Displacement that a facet prescribes at one of its nodes [m]; NaN = component is free.
    Vector3 prescribed_at(int facet, int node) const {
        const Vector3 prescribed = factor_at(node) * value[facet];
        return node_shift.empty() ? prescribed : Vector3(prescribed + node_shift[node]);
    }
    /// The same in the middle of an edge.
    double factor_between(int a, int b) const {
        return node_factor.empty() ? 1.0 : 0.5 * (node_factor[a] + node_factor[b]);
    }

    int num_facets() const { return static_cast<int>(condition_on.size()); } ///< T

    /// Condition on a facet; nullptr where it is free.
    const Condition *on(int facet) const {
        return condition_on[facet] < 0 ? nullptr : &conditions[condition_on[facet]];
    }
    /// Whether there is a condition of a kind, on whatever facets.
    bool has(ConditionKind kind) const;
    bool is_free(int facet) const { return condition_on[facet] < 0; }
    /// Whether a facet prescribes a displacement.
    bool is_constrained(int facet) const { return on(facet) && on(facet)->kind == ConditionKind::displacement; }
    /// Whether a facet has a traction, given or a result.
    bool is_loaded(int facet) const { return on(facet) && on(facet)->is_traction(); }
    /// Whether the traction on a facet is multiplied until the body has moved by press_depth.
    bool presses(int facet) const { return on(facet) && on(facet)->kind == ConditionKind::press; }
    /// Whether the traction on a facet is a pressure that follows the surface.
    bool follows_surface(int facet) const { return on(facet) && on(facet)->kind == ConditionKind::pressure; }
    /// Spread of the traction on a facet; nothing where it is the same everywhere.
    const RoundLoad *round_load_on(int facet) const {
        return on(facet) && on(facet)->round ? &*on(facet)->round : nullptr;
    }
    std::vector<RoundLoad> round_loads() const; ///< what round tools press or pull with

    std::vector<std::string> constraint_names() const; ///< (P) the places whose force is a result
    int num_constraints() const;                       ///< P
    /// Index into constraint_names(), -1 where a facet has no force that is a result.
    int constraint_on(int facet) const;
    std::vector<std::string> load_names() const; ///< (G) the places with a given traction
    /// Index into load_names(), -1 where a facet has no given traction.
    int load_on(int facet) const;

    /// Puts a condition on facets, each with the same value.
    void put(Condition condition, std::span<const int> facets, const Vector3 &same_value);
    /// Takes from a facet what is on it; its value stays.
    void free_facet(int facet) { condition_on[facet] = -1; }

    /// Whether a tool that touches may touch a facet.
    bool may_touch(int facet) const { return is_touched() && !is_constrained(facet); }
};

/// Calls a function with every event that happens.
void for_each_event(auto &load_case, const auto &visit) {
    std::apply([&](auto &...event) { ((event ? visit(*event) : void()), ...); }, load_case.events());
}

/// A surface that is free everywhere, as long as nothing is put on it.
LoadCase with_free_surface(LoadCase load_case, const TetraMesh &mesh);

/// The same with its tractions let go: what holds after a release.
LoadCase without_tractions(LoadCase load_case);

/// The same without the events in which time passes: its static start.
LoadCase without_time(LoadCase load_case);

/// The resultant of the tractions of each place, for one newton of all that press together.
/// @return shape (P) [1], zero where a place holds
std::vector<Vector3> press_resultants(const LoadCase &load_case, const TetraMesh &mesh);

/// Pressure on a facet that follows the surface, positive inwards [Pa]; 0 where nothing does.
double follower_pressure(const LoadCase &load_case, const TetraMesh &mesh, int facet);

/// The same without what follows the surface: with the loads that keep their direction.
LoadCase without_follower_pressures(LoadCase load_case);

/// Whether two load cases on one mesh have the same static solution: the same conditions, values and acceleration, to
/// the last bit, and the same path or slow history.
bool are_statically_equal(const LoadCase &a, const LoadCase &b);

/// Whether two load cases on one mesh constrain the same components of the displacement, wherever to: a factor of what
/// is free under one then serves the other.
bool constrain_the_same(const LoadCase &a, const LoadCase &b);

/// Whether every component that one load case on a mesh constrains is constrained under the other too, wherever to.
bool constrains_all_of(const LoadCase &more, const LoadCase &less);

/// The same with everything that drives it multiplied: tractions, accelerations and the prescribed displacements that
/// are not zero, or the depth to which it is pressed, or the way of a ball that touches. A linear body then moves by
/// the factor, but not where a ball touches more of it.
LoadCase scaled(LoadCase load_case, double factor);

/// The load case whose whole load is a part of this one's: one that presses first has pressed as far as then.
LoadCase cut_short(LoadCase load_case, double part);

/// Whether anything drives it: if not, every solution is zero and no factor changes that.
bool is_driven(const LoadCase &load_case);

} // namespace livermark::core
