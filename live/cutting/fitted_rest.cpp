#include "live/cutting/fitted_rest.hpp"

#include <limits>
#include <set>

#include "live/material.hpp"
#include "live/springs.hpp"
#include "msm/cutting/part_of_body.hpp"

namespace livermark::live {

namespace {

/// Of squared frequencies.
constexpr double of_frequencies = 1e-3;

/// The settings that leave the materials of a part as they are.
Settings settings_of_part(const core::Body &part, Settings settings) {
    settings.young_modulus = part.materials[largest_region(part.mesh)].young_modulus;
    return settings;
}

msm::MassSprings springs_of_part(const core::Body &part, const Settings &settings) {
    SpringsOfLaws none;
    return mass_springs(part, settings_of_part(part, settings), none);
}

} // namespace

FittedRest fit_rest(const core::Body &body, const std::vector<char> &is_gone, const msm::NodalConditions &conditions,
                    const Settings &settings) {
    std::vector<char> is_there;
    std::vector<int> tetrahedron;
    for (std::size_t t = 0; t < is_gone.size(); ++t) {
        is_there.push_back(is_gone[t] == 0 ? 1 : 0);
        if (is_gone[t] == 0)
            tetrahedron.push_back(static_cast<int>(t));
    }
    auto part = msm::part_of_body(body, is_there, conditions);
    auto springs = springs_of_part(part.body, settings);
    auto stepping = chosen_steps(part.body, springs, part.conditions, settings);
    return {std::move(part), std::move(tetrahedron), std::move(springs), std::move(stepping)};
}

msm::MassScaling scaling_of_whole(const FittedRest &rest) {
    auto scaling = rest.stepping.scaling;
    for (auto &part : scaling.parts)
        for (int &node : part.nodes)
            node = rest.part.node[node];
    return scaling;
}

std::vector<double> watched_of_whole(const FittedRest &rest, const Stepping &stepping, std::size_t num_tetrahedra) {
    const auto watched = watched_volumes(rest.part.body, rest.springs, rest.part.conditions, stepping);
    if (watched.empty())
        return {};
    std::vector<double> whole(num_tetrahedra, 0.0);
    for (std::size_t t = 0; t < watched.size(); ++t)
        whole[rest.tetrahedron[t]] = watched[t];
    return whole;
}

double critical_step_around(const core::Body &body, const std::vector<char> &is_gone, std::span<const int> gone,
                            msm::NodalConditions conditions, const msm::MassScaling &scaling,
                            const Settings &settings) {
    std::set<int> nodes;
    for (const int t : gone)
        nodes.insert(body.mesh.tetrahedra[t].begin(), body.mesh.tetrahedra[t].end());
    for (const auto &part : scaling.parts)
        for (const int node : part.nodes)
            conditions.displacement[node].setZero();
    const std::vector<int> around(nodes.begin(), nodes.end());
    const double highest = msm::frequency_around(
        body, is_gone, around, [&](const core::Body &part) { return springs_of_part(part, settings).body; }, conditions,
        of_frequencies);
    return highest > 0.0 ? critical_step(highest, settings) : std::numeric_limits<double>::infinity();
}

} // namespace livermark::live
