#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <string>
#include <vector>

#include "core/support/input_error.hpp"
#include "core/tool/needle/needle_line.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/nodal_conditions.hpp"
#include "msm/spring_law.hpp"
#include "msm/springs/spring_network.hpp"
#include "results/records/needle.hpp"
#include "studies/models/model_table.hpp"
#include "studies/needle/insertion.hpp"
#include "tests/samples/needle_in_springs.hpp"
#include "tests/samples/random_needles.hpp"
#include "tests/studies/moving_insertion.hpp"

namespace livermark::tests {

/// Of the work of the hand.
inline constexpr double most_out_of_balance = 0.02;

/// What is wrong with an insertion; empty if nothing is.
inline std::string fault_of(const core::Insertion &insertion, const core::Needle &needle, double energy_error) {
    const auto is_finite = [](double value) { return std::isfinite(value); };
    if (!std::ranges::all_of(insertion.force, is_finite) || !std::ranges::all_of(insertion.tip, is_finite) ||
        !std::ranges::all_of(insertion.target, [](const core::Vector3 &u) { return u.allFinite(); }))
        return "something is not finite";
    if (!(energy_error < most_out_of_balance))
        return fmt::format("work is out of balance by {:.2f} %", 100.0 * energy_error);
    const double most = needle.puncture_force + needle.friction * needle.depth();
    if (!(*std::ranges::max_element(insertion.force) <= most * (1.0 + 1e-6)))
        return fmt::format("the hand pushes with {} N, more than {} N", *std::ranges::max_element(insertion.force),
                           most);
    return {};
}

/// Drives needles into models by turns.
/// @return a sentence for each with a fault
inline std::vector<std::string> drive_random_needles(const std::string &body, const std::string &held, unsigned seed,
                                                     int count) {
    constexpr std::array models{"fem_p1", "patch", "van_gelder"};
    const auto all = models::all_models();
    RandomNeedles random(body, held, seed);
    std::vector<std::string> faults;
    for (int n = 0; n < count; ++n) {
        const auto [problem, needle] = random.next();
        const std::string name = models[static_cast<std::size_t>(n) % models.size()];
        const auto line = core::needle_line(needle);
        const auto compliance = support::find_named(all, name, "model").compliance(problem, line.places);
        const results::NeedleRun run{
            .model = name, .insertion = studies::insert(compliance.matrix, line, needle), .setup_seconds = 0.0};
        auto fault = fault_of(run.insertion, needle, run.energy_error());
        if (fault.empty() && std::abs(run.insertion.force.back()) > 1e-6)
            fault = fmt::format("{} N are left when it is out", run.insertion.force.back());
        if (!fault.empty())
            faults.push_back(fmt::format("{} needle {}, {}: {}", body, n, name, fault));
    }
    return faults;
}

/// Drives needles into patch springs in steps, at 2 to 10 cm/s.
/// @return a sentence for each with a fault
inline std::vector<std::string> step_random_needles(const std::string &body, const std::string &held, unsigned seed,
                                                    int count) {
    constexpr double of_critical_step = 0.25; // pressed in by centimetres, springs are stiffer than at rest
    RandomNeedles random(body, held, seed);
    std::vector<std::string> faults;
    std::optional<msm::ElasticBody> springs;
    double time_step = 0.0;
    for (int n = 0; n < count; ++n) {
        auto [problem, needle] = random.next();
        needle.step = 1e-3; // of records
        if (!springs) {
            const auto beside = msm::springs_beside_volume(
                *problem.body, support::find_named(msm::all_spring_laws(), "patch", "spring law"));
            springs = msm::springs_with_volume(*problem.body, beside, msm::find_volume_term("nodal_volume")).body;
        }
        const auto conditions = msm::nodal_conditions(problem, springs->node_mass);
        if (time_step == 0.0)
            time_step = of_critical_step * 2.0 /
                        msm::largest_angular_frequency(*springs, problem.body->mesh.points, conditions);
        const auto found = insert_in_steps(
            *springs, problem.body->mesh, conditions, needle,
            {.speed = 0.02 + 0.08 * random.part(),
             .time_step = time_step,
             .damping = {20.0, 0.0},
             .precision = n % 4 == 0 ? msm::ForcePrecision::double_precision : msm::ForcePrecision::single_precision});
        const auto fault = fault_of(found.record, needle, found.energy_error());
        if (!fault.empty())
            faults.push_back(fmt::format("{} needle {} in steps: {}", body, n, fault));
    }
    return faults;
}

} // namespace livermark::tests
