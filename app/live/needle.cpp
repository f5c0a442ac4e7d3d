#include "app/live/needle.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <utility>

#include "core/mesh/places.hpp"
#include "core/support/input_error.hpp"

namespace livermark::live {

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
           m.puncture_force == n.puncture_force;
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
