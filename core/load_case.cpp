#include "core/load_case.hpp"

#include <algorithm>
#include <cmath>

namespace livermark::core {

const char *to_string(Regime regime) {
    return regime == Regime::large ? "large" : "small";
}

LoadCase without_tractions(LoadCase load_case) {
    for (std::size_t facet = 0; facet < load_case.condition.size(); ++facet)
        if (load_case.condition[facet] == FacetCondition::traction) {
            load_case.condition[facet] = FacetCondition::free;
            load_case.constraint[facet] = -1;
        }
    load_case.load_names.clear();
    load_case.load.clear();
    load_case.press_depth = 0.0;
    return load_case;
}

std::vector<Vector3> press_resultants(const LoadCase &load_case, const TetraMesh &mesh) {
    std::vector<Vector3> resultant(load_case.constraint_names.size(), Vector3::Zero());
    for (int facet = 0; facet < mesh.num_boundary_triangles(); ++facet)
        if (load_case.presses(facet))
            resultant[load_case.constraint[facet]] += area_vector(mesh, facet).norm() * load_case.value[facet];
    return resultant;
}

double follower_pressure(const LoadCase &load_case, const TetraMesh &mesh, int facet) {
    return load_case.follows_surface(facet) ? -load_case.value[facet].dot(area_vector(mesh, facet).normalized()) : 0.0;
}

LoadCase without_follower_pressures(LoadCase load_case) {
    for (std::size_t facet = 0; facet < load_case.condition.size(); ++facet)
        if (load_case.follows_surface(static_cast<int>(facet)))
            load_case.condition[facet] = FacetCondition::free;
    return load_case;
}

bool are_statically_equal(const LoadCase &a, const LoadCase &b) {
    const auto same_component = [](double x, double y) { return x == y || (std::isnan(x) && std::isnan(y)); };
    const auto same_value = [&](const Vector3 &x, const Vector3 &y) {
        return std::equal(x.begin(), x.end(), y.begin(), same_component);
    };
    return a.regime == b.regime && a.path == b.path && a.slow_history == b.slow_history && a.follows == b.follows &&
           a.node_factor == b.node_factor && a.node_shift == b.node_shift && a.round_loads == b.round_loads &&
           a.round_load == b.round_load && a.condition == b.condition && a.constraint == b.constraint &&
           a.press_depth == b.press_depth && a.touching == b.touching && a.acceleration == b.acceleration &&
           std::ranges::equal(a.value, b.value, same_value);
}

bool constrain_the_same(const LoadCase &a, const LoadCase &b) {
    return constrains_all_of(a, b) && constrains_all_of(b, a);
}

bool constrains_all_of(const LoadCase &more, const LoadCase &less) {
    const auto is_constrained = [](const LoadCase &load_case, std::size_t facet, int component) {
        return load_case.condition[facet] == FacetCondition::prescribed_displacement &&
               !std::isnan(load_case.value[facet][component]);
    };
    if (more.condition.size() != less.condition.size())
        return false;
    for (std::size_t facet = 0; facet < less.condition.size(); ++facet)
        for (int component = 0; component < 3; ++component)
            if (is_constrained(less, facet, component) && !is_constrained(more, facet, component))
                return false;
    return true;
}

LoadCase scaled(LoadCase load_case, double factor) {
    for (int facet = 0; facet < static_cast<int>(load_case.value.size()); ++facet)
        if (!load_case.presses(facet))
            load_case.value[facet] *= factor; // NaN, a free component, stays NaN
    for (auto &shift : load_case.node_shift)
        shift *= factor;
    load_case.press_depth *= factor;
    if (load_case.touching) {
        load_case.touching->press *= factor;
        load_case.touching->slide *= factor;
    }
    load_case.acceleration *= factor;
    load_case.load_scale *= factor;
    return load_case;
}

bool is_driven(const LoadCase &load_case) {
    const auto is_load = [](double component) { return component < 0.0 || component > 0.0; }; // not NaN
    const auto drives = [&](const Vector3 &value) { return std::ranges::any_of(value, is_load); };
    return is_load(load_case.press_depth) || (load_case.touching && drives(load_case.touching->press)) ||
           drives(load_case.acceleration) || std::ranges::any_of(load_case.value, drives) ||
           std::ranges::any_of(load_case.node_shift, drives);
}

} // namespace livermark::core
