#include "core/load_case.hpp"

#include <algorithm>

namespace livermark::core {

LoadCase without_tractions(LoadCase load_case) {
    for (auto &condition : load_case.condition)
        if (condition == FacetCondition::traction)
            condition = FacetCondition::free;
    return load_case;
}

LoadCase scaled(LoadCase load_case, double factor) {
    for (auto &value : load_case.value)
        value *= factor; // NaN, a free component, stays NaN
    load_case.acceleration *= factor;
    load_case.load_scale *= factor;
    return load_case;
}

bool is_driven(const LoadCase &load_case) {
    const auto is_load = [](double component) { return component < 0.0 || component > 0.0; }; // not NaN
    const auto drives = [&](const Vector3 &value) { return std::ranges::any_of(value, is_load); };
    return drives(load_case.acceleration) || std::ranges::any_of(load_case.value, drives);
}

} // namespace livermark::core
