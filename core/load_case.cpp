#include "core/load_case.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <tuple>
#include <type_traits>
#include <utility>

namespace livermark::core {

namespace {

std::array<double, 3> linear_shapes(const Vector3 &at) {
    return {at[0], at[1], at[2]};
}

std::array<double, 6> quadratic_shapes(const Vector3 &at) {
    return {at[0] * (2.0 * at[0] - 1.0), at[1] * (2.0 * at[1] - 1.0), at[2] * (2.0 * at[2] - 1.0),
            4.0 * at[0] * at[1],         4.0 * at[1] * at[2],         4.0 * at[2] * at[0]};
}

/// Means of h times each shape function over the mean of h.
/// @param even  where the traction is the same everywhere, and where a triangle is beyond the rim
template <std::size_t nodes>
std::array<double, nodes> parts_of(const RoundLoad *load, const Corners &corners,
                                   std::array<double, nodes> (*shapes)(const Vector3 &),
                                   const std::array<double, nodes> &even) {
    if (!load)
        return even;
    std::array<double, nodes> moment{};
    double sum = 0.0;
    visit_triangle_parts([&](const Vector3 &at) {
        const double height = load->height(point_at(corners, at));
        const auto shape = shapes(at);
        for (std::size_t k = 0; k < nodes; ++k)
            moment[k] += height * shape[k];
        sum += height;
    });
    if (sum == 0.0)
        return even;
    for (double &value : moment)
        value /= sum;
    return moment;
}

} // namespace

double RoundLoad::height(const Vector3 &point) const {
    return std::sqrt(std::max(0.0, 1.0 - (point - middle).squaredNorm() / (radius * radius)));
}

Corners corners_of(const TetraMesh &mesh, int facet) {
    const auto &[a, b, c] = mesh.boundary_triangles[facet];
    return {mesh.points[a], mesh.points[b], mesh.points[c]};
}

Vector3 point_at(const Corners &corners, const Vector3 &barycentric) {
    return barycentric[0] * corners[0] + barycentric[1] * corners[1] + barycentric[2] * corners[2];
}

double mean_height(const RoundLoad &load, const Corners &corners) {
    double sum = 0.0;
    visit_triangle_parts([&](const Vector3 &at) { sum += load.height(point_at(corners, at)); });
    return sum / num_triangle_parts;
}

std::array<double, 3> linear_parts(const RoundLoad *load, const Corners &corners) {
    constexpr double third = 1.0 / 3.0;
    return parts_of<3>(load, corners, linear_shapes, {third, third, third});
}

std::array<double, 6> quadratic_parts(const RoundLoad *load, const Corners &corners) {
    constexpr double third = 1.0 / 3.0;
    return parts_of<6>(load, corners, quadratic_shapes, {0.0, 0.0, 0.0, third, third, third});
}

std::vector<double> shares_of_parts(const RoundLoad *load, std::span<const Corners> parts) {
    std::vector<double> share(parts.size(), 1.0);
    if (!load)
        return share;
    double pressed = 0.0, area = 0.0;
    for (std::size_t k = 0; k < parts.size(); ++k) {
        const auto &[a, b, c] = parts[k];
        const double part = 0.5 * (b - a).cross(c - a).norm();
        share[k] = mean_height(*load, parts[k]);
        pressed += part * share[k];
        area += part;
    }
    for (double &value : share)
        value *= pressed > 0.0 ? area / pressed : 0.0;
    return share;
}

namespace {

using IsOfKind = bool (Condition::*)() const;

std::vector<std::string> places_where(const LoadCase &load_case, IsOfKind is_of_kind) {
    std::vector<std::string> names;
    for (const auto &condition : load_case.conditions)
        if ((condition.*is_of_kind)())
            names.push_back(condition.place);
    return names;
}

/// Number of the condition on a facet among those of a kind; -1 where it has none of them.
int number_among(const LoadCase &load_case, int facet, IsOfKind is_of_kind) {
    const auto *const found = load_case.on(facet);
    if (!found || !(found->*is_of_kind)())
        return -1;
    return static_cast<int>(std::count_if(load_case.conditions.data(), found,
                                          [=](const Condition &before) { return (before.*is_of_kind)(); }));
}

/// Whether events that are a part of the static solution are the same in both.
bool have_same_static_events(const LoadCase &a, const LoadCase &b) {
    const auto are_same = [&]<class Kind>(const std::optional<Kind> &in_a) {
        if constexpr (requires { Kind::decides_statics; })
            return in_a == std::get<const std::optional<Kind> &>(b.events());
        return true;
    };
    return std::apply([&](const auto &...event) { return (are_same(event) && ...); }, a.events());
}

/// All but the events.
LoadCase with_scaled_conditions(LoadCase load_case, double factor) {
    for (int facet = 0; facet < load_case.num_facets(); ++facet)
        if (!load_case.presses(facet))
            load_case.value[facet] *= factor; // NaN, a free component, stays NaN
    for (auto &shift : load_case.node_shift)
        shift *= factor;
    load_case.press_depth *= factor;
    load_case.acceleration *= factor;
    load_case.load_scale *= factor;
    return load_case;
}

/// Whether both do the same to their facets, whatever their places are called.
bool are_alike(const Condition *a, const Condition *b) {
    return a && b ? a->kind == b->kind && a->round == b->round : a == b;
}

} // namespace

const char *to_string(Regime regime) {
    return regime == Regime::large ? "large" : "small";
}

bool LoadCase::has(ConditionKind kind) const {
    return std::ranges::find(conditions, kind, &Condition::kind) != conditions.end();
}

std::vector<RoundLoad> LoadCase::round_loads() const {
    std::vector<RoundLoad> loads;
    for (const auto &condition : conditions)
        if (condition.round)
            loads.push_back(*condition.round);
    return loads;
}

std::vector<std::string> LoadCase::constraint_names() const {
    return places_where(*this, &Condition::is_constraint);
}

int LoadCase::num_constraints() const {
    return static_cast<int>(std::ranges::count_if(conditions, &Condition::is_constraint));
}

int LoadCase::constraint_on(int facet) const {
    return number_among(*this, facet, &Condition::is_constraint);
}

std::vector<std::string> LoadCase::load_names() const {
    return places_where(*this, &Condition::is_given_load);
}

int LoadCase::load_on(int facet) const {
    return number_among(*this, facet, &Condition::is_given_load);
}

EventSet LoadCase::kinds() const {
    EventSet kinds;
    for_each_event(*this, [&](const auto &event) { kinds.add<std::decay_t<decltype(event)>>(); });
    return kinds;
}

bool LoadCase::in_time() const {
    bool passes = false;
    for_each_event(*this, [&](const auto &event) { passes = passes || event.in_time; });
    return passes;
}

bool LoadCase::is_touched() const {
    bool is_touched = false;
    for_each_event(*this, [&](const auto &event) {
        is_touched = is_touched || requires {
            event.contacts();
        };
    });
    return is_touched;
}

std::vector<ExpectedContact> LoadCase::contacts() const {
    std::vector<ExpectedContact> contacts;
    for_each_event(*this, [&](const auto &event) {
        if constexpr (requires { event.contacts(); })
            contacts = event.contacts();
    });
    return contacts;
}

double LoadCase::contact_depth() const {
    return is_touched() ? contacts().front().press.norm() : 0.0;
}

void LoadCase::put(Condition condition, std::span<const int> facets, const Vector3 &same_value) {
    for (const int facet : facets) {
        condition_on[facet] = static_cast<int>(conditions.size());
        value[facet] = same_value;
    }
    conditions.push_back(std::move(condition));
}

LoadCase with_free_surface(LoadCase load_case, const TetraMesh &mesh) {
    load_case.condition_on.assign(mesh.boundary_triangles.size(), -1);
    load_case.value.assign(mesh.boundary_triangles.size(), Vector3::Constant(std::numeric_limits<double>::quiet_NaN()));
    return load_case;
}

LoadCase without_tractions(LoadCase load_case) {
    for (int facet = 0; facet < load_case.num_facets(); ++facet)
        if (load_case.is_loaded(facet))
            load_case.free_facet(facet);
    load_case.press_depth = 0.0;
    return load_case;
}

LoadCase without_time(LoadCase load_case) {
    const auto remove = []<class Kind>(std::optional<Kind> &event) {
        if (Kind::in_time)
            event.reset();
    };
    std::apply([&](auto &...event) { (remove(event), ...); }, load_case.events());
    return load_case;
}

std::vector<Vector3> press_resultants(const LoadCase &load_case, const TetraMesh &mesh) {
    std::vector<Vector3> resultant(load_case.num_constraints(), Vector3::Zero());
    for (int facet = 0; facet < mesh.num_boundary_triangles(); ++facet)
        if (load_case.presses(facet))
            resultant[load_case.constraint_on(facet)] += area_vector(mesh, facet).norm() * load_case.value[facet];
    return resultant;
}

double follower_pressure(const LoadCase &load_case, const TetraMesh &mesh, int facet) {
    return load_case.follows_surface(facet) ? -load_case.value[facet].dot(area_vector(mesh, facet).normalized()) : 0.0;
}

LoadCase without_follower_pressures(LoadCase load_case) {
    for (int facet = 0; facet < load_case.num_facets(); ++facet)
        if (load_case.follows_surface(facet))
            load_case.free_facet(facet);
    return load_case;
}

bool are_statically_equal(const LoadCase &a, const LoadCase &b) {
    const auto same_component = [](double x, double y) { return x == y || (std::isnan(x) && std::isnan(y)); };
    const auto same_value = [&](const Vector3 &x, const Vector3 &y) {
        return std::equal(x.begin(), x.end(), y.begin(), same_component);
    };
    const auto same_conditions = [&] {
        for (int facet = 0; facet < a.num_facets(); ++facet)
            if (!are_alike(a.on(facet), b.on(facet)) || a.constraint_on(facet) != b.constraint_on(facet))
                return false;
        return true;
    };
    return a.regime == b.regime && a.path == b.path && have_same_static_events(a, b) &&
           a.node_factor == b.node_factor && a.node_shift == b.node_shift && a.press_depth == b.press_depth &&
           a.acceleration == b.acceleration && std::ranges::equal(a.value, b.value, same_value) &&
           a.num_facets() == b.num_facets() && same_conditions();
}

bool constrain_the_same(const LoadCase &a, const LoadCase &b) {
    return constrains_all_of(a, b) && constrains_all_of(b, a);
}

bool constrains_all_of(const LoadCase &more, const LoadCase &less) {
    const auto is_constrained = [](const LoadCase &load_case, int facet, int component) {
        return load_case.is_constrained(facet) && !std::isnan(load_case.value[facet][component]);
    };
    if (more.num_facets() != less.num_facets())
        return false;
    for (int facet = 0; facet < less.num_facets(); ++facet)
        for (int component = 0; component < 3; ++component)
            if (is_constrained(less, facet, component) && !is_constrained(more, facet, component))
                return false;
    return true;
}

LoadCase scaled(LoadCase load_case, double factor) {
    for_each_event(load_case, [&](auto &event) {
        if constexpr (requires { event.scale(factor); })
            event.scale(factor);
    });
    return with_scaled_conditions(std::move(load_case), factor);
}

LoadCase cut_short(LoadCase load_case, double part) {
    for_each_event(load_case, [&](auto &event) {
        if constexpr (requires { event.cut_short(part); })
            event.cut_short(part);
    });
    return with_scaled_conditions(std::move(load_case), part);
}

bool is_driven(const LoadCase &load_case) {
    const auto is_load = [](double component) { return component < 0.0 || component > 0.0; }; // not NaN
    const auto drives = [&](const Vector3 &value) { return std::ranges::any_of(value, is_load); };
    return is_load(load_case.press_depth) || is_load(load_case.contact_depth()) || drives(load_case.acceleration) ||
           std::ranges::any_of(load_case.value, drives) || std::ranges::any_of(load_case.node_shift, drives);
}

} // namespace livermark::core
