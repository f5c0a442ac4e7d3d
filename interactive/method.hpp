#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "interactive/simulation.hpp"

namespace livermark::interactive {

/// A frame of a display, 60 times a second [s].
inline constexpr double frame_time = 1.0 / 60.0;

/// A deformable method. One file each in methods/, named as the method.
struct Method {
    std::string name;              ///< the file stem; set by the table
    std::string summary;           ///< one line
    std::string source;            ///< literature reference
    std::string energy;            ///< the equation of the energy behind it
    std::string converges_to;      ///< one line: what a step comes to as iterations grow
    std::string objection;         ///< what its users or authors object to, each with a source; how to see it here
    std::string implementation;    ///< one line: how good it is, and its number format
    double time_step = frame_time; ///< where nothing else is asked for [s]
    int iterations = 10;           ///< in a step, where nothing else is asked for
    bool is_explicit = false;      ///< whether its steps can be corrected, and have a critical time step
    bool knows_contact = false;    ///< whether a ball can touch(), see Simulation
    /// Puts the method on a scene, at rest.
    std::function<std::unique_ptr<Simulation>(const Scene &)> prepare;
};

/// Every method of methods/, in alphabetical order.
std::span<const Method> all_methods();

/// @throws std::invalid_argument if there is none of that name
const Method &find_method(std::string_view name);

} // namespace livermark::interactive
