#include "results/records/result.hpp"

#include <chrono>
#include <cmath>
#include <fmt/chrono.h>
#include <fstream>
#include <limits>
#include <thread>
#include <utility>

#include "core/error_norms.hpp"

namespace livermark::results {

ReferenceUncertainty estimate_uncertainty(const core::TetraMesh &mesh, const core::LoadCase &load_case,
                                          const core::Solution &coarse, const std::string &coarse_name,
                                          const core::Solution &refined, const std::string &refined_name) {
    const auto difference = core::compare(mesh, load_case, coarse, refined, refined_name);
    const double ratio = std::exp2(order_at_patch_edges);
    const double coarse_share = ratio / (ratio - 1.0);
    const double refined_share = 1.0 / (ratio - 1.0);
    const bool coarse_will_do = coarse_share * difference.relative_l2 <= largest_coarse_error;
    const double share = coarse_will_do ? coarse_share : refined_share;
    std::optional<double> stiffness;
    if (difference.tool && !std::isnan(difference.tool->stiffness()))
        stiffness = share * std::abs(difference.tool->stiffness());
    return {.reference = coarse_will_do ? coarse_name : refined_name,
            .refined = refined_name,
            .refinement_difference = difference.relative_l2,
            .order = order_at_patch_edges,
            .relative_l2 = share * difference.relative_l2,
            .energy_error = share * std::abs(difference.energy_error),
            .reaction_error = share * difference.reaction_error,
            .stiffness = stiffness};
}

MotionUncertainty estimate_motion_uncertainty(const core::History &coarse, const std::string &coarse_name,
                                              const core::History &refined, const std::string &refined_name) {
    const double difference = core::compare(coarse, refined, refined_name).relative_l2;
    const auto &observed = refined.observed_error;
    const double ratio = coarse.time_step > 0.0 ? refined.time_step / coarse.time_step : 1.0;
    const double steps = coarse.observed_error ? ratio * ratio * coarse.observed_error->relative_l2 : 0.0;
    const double refined_error = (observed ? observed->relative_l2 : difference) + steps;
    const double coarse_error = difference + refined_error;
    const bool coarse_will_do = coarse_error <= largest_coarse_error;
    return {.reference = coarse_will_do ? coarse_name : refined_name,
            .refined = refined_name,
            .difference = difference,
            .order = observed ? observed->order : order_at_patch_edges,
            .relative_l2 = coarse_will_do ? coarse_error : refined_error};
}

std::optional<MotionUncertainty> uncertainty_of_steps(const core::History &motion, const std::string &name) {
    const auto &steps = motion.observed_error;
    if (!steps)
        return std::nullopt;
    return MotionUncertainty{.reference = name,
                             .refined = name,
                             .difference = std::numeric_limits<double>::quiet_NaN(),
                             .order = steps->order,
                             .relative_l2 = steps->relative_l2};
}

namespace {

std::string cpu_name() {
    std::ifstream info("/proc/cpuinfo");
    for (std::string line; std::getline(info, line);)
        if (line.starts_with("model name"))
            if (const auto colon = line.find(": "); colon != std::string::npos)
                return line.substr(colon + 2);
    return "unknown";
}

std::string now_utc() {
    return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}",
                       fmt::gmtime(std::chrono::system_clock::to_time_t(std::chrono::system_clock::now())));
}

} // namespace

Provenance current_provenance(std::string command) {
    Provenance provenance;
    provenance.software_version = LIVERMARK_VERSION;
    provenance.git_commit = git_commit();
    provenance.created = now_utc();
    provenance.command = std::move(command);
    provenance.cpu = cpu_name();
    provenance.compiler = LIVERMARK_COMPILER;
    provenance.build_type = LIVERMARK_BUILD_TYPE;
    // glibc counts the processors that this process may run on, not those of the machine.
    provenance.threads = static_cast<int>(std::thread::hardware_concurrency());
    return provenance;
}

} // namespace livermark::results
