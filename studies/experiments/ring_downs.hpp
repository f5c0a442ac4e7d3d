#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/model.hpp"
#include "core/rayleigh_damping.hpp"
#include "load_cases/experiments/experiment.hpp"
#include "results/records/experiment.hpp"

namespace livermark::studies {

/// Which forces damp.
enum class DampingForces {
    rayleigh, ///< of mass and stiffness, with one ratio at the lowest and the highest measured frequency
    mass,     ///< alpha M alone
    stiffness ///< beta K alone
};

/// Damping that has the measured ratio at the measured frequency of one ring-down.
/// @param ratio           zeta, > 0
/// @param frequency       there [Hz]
/// @param lowest, highest of all ring-downs [Hz]; both `frequency` where there is one
core::RayleighDamping fitted_damping(DampingForces kind, double ratio, double frequency, double lowest, double highest);

/// What a ring-down says without a model.
/// @param positions  of the markers at rest [m]
/// @param markers    that are compared
results::RingDownResult measured_ring_down(const experiments::RingDown &ring_down,
                                           std::span<const core::Vector3> positions, std::span<const int> markers);

/// A model that rings down. It starts at rest under what holds the body, with that multiplied so that the markers are
/// as near to where they were measured at t = 0 as one factor can bring them.
/// @param measured      its `runs` are not read
/// @param at_frequency  where interactive methods, which damp by the mass alone, have the same ratio [Hz]
/// @return no run of a model that does not move in time
std::vector<results::RingDownRun> ring_down_of_model(const core::Model &model, const experiments::RingDown &ring_down,
                                                     const results::RingDownResult &measured, double edge_length,
                                                     const core::RayleighDamping &damping, double at_frequency,
                                                     std::span<const core::Vector3> positions,
                                                     std::span<const int> markers);

} // namespace livermark::studies
