#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/tool/round_load.hpp"

namespace livermark::core {

/// What a condition does to the facets of its place.
enum class ConditionKind : std::uint8_t {
    displacement, ///< prescribes components of it
    traction,     ///< a given one, which keeps its direction
    pressure,     ///< stays perpendicular to the surface and acts on its area as that moves; its value is the traction
                  ///< at rest, which linear models take
    press,        ///< tractions that all are multiplied by one number until the body has moved by LoadCase::press_depth
    touch         ///< what LoadCase::touching exerts; it has no facets, because contact finds them
};

/// What a load case puts on one place. Which facets it has and what each of them prescribes is in LoadCase.
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

} // namespace livermark::core
