#include "experiments/experiment.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "core/mesh/bounding_box.hpp"
#include "core/units.hpp"
#include "experiments/marker_field.hpp"
#include "support/input_error.hpp"

namespace livermark::experiments {

namespace {

using core::Vector3;

/// Parts of the extent and of the thinnest side of a body: how far a marker may stand off it.
constexpr double largest_peg = 0.2, largest_peg_of_side = 0.5;
constexpr std::size_t fewest_compared = 3;

} // namespace

void check(const Experiment &experiment, const std::string &place) {
    const auto body = experiment.body(experiment.edge_length);
    const double extent = core::extent(body.mesh.points);
    const double thinnest = core::bounding_box(body.mesh.points).sizes().minCoeff();
    const double farthest = std::min(largest_peg * extent, largest_peg_of_side * thinnest);
    std::vector<Vector3> positions;
    for (const auto &marker : experiment.markers)
        positions.push_back(marker.position);
    const auto outside = MarkerField(body.mesh, positions).outside();
    for (std::size_t k = 0; k < outside.size(); ++k)
        if (!(outside[k] <= farthest))
            throw support::InputError(fmt::format(
                "{}: marker {} is {:.3g} mm outside the body, and {:.3g} mm are the most for one on a peg (half "
                "of the thinnest side, a fifth of the diagonal); check the unit and the frame of the "
                "markers, and where the body is",
                place, experiment.markers[k].name, core::millimetres * outside[k], core::millimetres * farthest));
    if (experiment.states.empty())
        throw support::InputError(fmt::format("{}: nothing was measured; add a state", place));
    for (const auto &ring_down : experiment.ring_downs)
        for (const auto &repeat : ring_down.repeats)
            for (const auto &displacement : repeat.displacement)
                if (!(displacement.norm() <= extent))
                    throw support::InputError(
                        fmt::format("{}: a marker is {:.3g} m from rest while {} rings down, and the body is {:.3g} m "
                                    "across; check the unit and whether positions stand where displacements should",
                                    place, displacement.norm(), ring_down.state, extent));
    for (const auto &state : experiment.states) {
        std::size_t num_compared = 0;
        if (state.displacement.size() != experiment.markers.size())
            throw support::InputError(fmt::format("{}: state {} has {} markers and the body {}; give each a position",
                                                  place, state.name, state.displacement.size(),
                                                  experiment.markers.size()));
        for (std::size_t k = 0; k < state.displacement.size(); ++k) {
            const auto &displacement = state.displacement[k];
            const bool is_seen = displacement.allFinite();
            if (is_seen && displacement.norm() > extent)
                throw support::InputError(
                    fmt::format("{}: marker {} moved by {:.3g} m in state {}, and the body is {:.3g} m across; check "
                                "the unit and whether positions stand where displacements should",
                                place, experiment.markers[k].name, displacement.norm(), state.name, extent));
            if (experiment.markers[k].drives.empty() && is_seen)
                ++num_compared;
        }
        if (num_compared < fewest_compared)
            throw support::InputError(fmt::format("{}: {} markers can be compared in state {}; {} are needed", place,
                                                  num_compared, state.name, fewest_compared));
    }
}

std::vector<PlaceMotion> driven_places(const Experiment &experiment, const MeasuredState &state) {
    std::vector<std::string> patches;
    for (const auto &marker : experiment.markers)
        if (!marker.drives.empty() && std::ranges::find(patches, marker.drives) == patches.end())
            patches.push_back(marker.drives);
    std::vector<PlaceMotion> places;
    for (const auto &patch : patches) {
        std::vector<Vector3> positions, displacements;
        for (std::size_t k = 0; k < experiment.markers.size(); ++k)
            if (experiment.markers[k].drives == patch) {
                positions.push_back(experiment.markers[k].position);
                displacements.push_back(state.displacement[k]);
            }
        places.push_back({patch, FittedMotion(positions, displacements, experiment.fit_degree,
                                              fmt::format("{}: place {}", experiment.name, patch))});
    }
    return places;
}

core::Problem problem_of(const Experiment &experiment, const MeasuredState &state,
                         const std::shared_ptr<const core::Body> &body) {
    core::Problem problem{body, state.load_case(body->mesh)};
    for (const auto &place : driven_places(experiment, state))
        drive(problem.load_case, body->mesh, place);
    return problem;
}

} // namespace livermark::experiments
