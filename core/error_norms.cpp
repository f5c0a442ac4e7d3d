#include "core/error_norms.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <stdexcept>

namespace livermark::core {

namespace {

void check_comparable(const TetraMesh &mesh, const Solution &solution, const Solution &reference,
                      const std::string &reference_name) {
    if (reference.status != SolutionStatus::ok)
        throw std::invalid_argument(fmt::format("the reference {} is {}; there is nothing to compare with",
                                                reference_name, to_string(reference.status)));
    if (solution.displacement.size() != mesh.points.size() || reference.displacement.size() != mesh.points.size())
        throw std::invalid_argument(fmt::format("cannot compare {} and {} node displacements on a mesh of {} nodes",
                                                solution.displacement.size(), reference.displacement.size(),
                                                mesh.points.size()));
    if (solution.reaction.size() != reference.reaction.size())
        throw std::invalid_argument(
            fmt::format("cannot compare {} reactions with {}", solution.reaction.size(), reference.reaction.size()));
}

/// max() that lets a NaN through: std::max(x, NaN) would hide one.
double max_or_nan(double a, double b) {
    return std::isnan(a) || std::isnan(b) ? std::numeric_limits<double>::quiet_NaN() : std::max(a, b);
}

/// Below this part of a force that would do the work of the load case on its peak displacement, reactions are rounding.
constexpr double smallest_reaction = 1e-6;

/// @param force  of the order of what is at work [N]
double relative_reaction_error(const Solution &solution, const Solution &reference, double force) {
    double difference = 0.0;
    double total = 0.0;
    for (std::size_t p = 0; p < reference.reaction.size(); ++p) {
        difference += (solution.reaction[p] - reference.reaction[p]).squaredNorm();
        total += reference.reaction[p].squaredNorm();
    }
    if (!(std::sqrt(total) > smallest_reaction * force))
        return std::numeric_limits<double>::quiet_NaN();
    return std::sqrt(difference / total);
}

} // namespace

const char *to_string(SolutionStatus status) {
    switch (status) {
    case SolutionStatus::ok:
        return "ok";
    case SolutionStatus::diverged:
        return "diverged";
    case SolutionStatus::not_converged:
        return "not_converged";
    }
    return "unknown";
}

Comparison compare(const TetraMesh &mesh, const Solution &solution, const Solution &reference,
                   const std::string &reference_name) {
    check_comparable(mesh, solution, reference, reference_name);
    const auto volumes = nodal_volumes(mesh);
    Comparison result;
    result.reference = reference_name;
    result.error.reserve(volumes.size());
    double squared_error = 0.0;
    double squared_reference = 0.0;
    double peak = 0.0;
    for (std::size_t i = 0; i < volumes.size(); ++i) {
        const Vector3 error = solution.displacement[i] - reference.displacement[i];
        squared_error += volumes[i] * error.squaredNorm();
        squared_reference += volumes[i] * reference.displacement[i].squaredNorm();
        result.max_error = max_or_nan(result.max_error, error.norm());
        peak = max_or_nan(peak, reference.displacement[i].norm());
        result.error.push_back(error);
    }
    if (!(squared_reference > 0.0))
        throw std::invalid_argument(
            fmt::format("the reference {} does not move; give the load case a load", reference_name));
    result.relative_l2 = std::sqrt(squared_error / squared_reference);
    result.max_error_relative = result.max_error / peak;
    result.energy_error = (solution.strain_energy - reference.strain_energy) / reference.strain_energy;
    result.reaction_error = relative_reaction_error(solution, reference, reference.strain_energy / peak);
    return result;
}

HistoryComparison compare(const History &history, const History &reference, const std::string &reference_name) {
    if (history.time != reference.time || history.displacement.size() != reference.displacement.size() ||
        history.frames.size() != reference.frames.size())
        throw std::invalid_argument("cannot compare histories that were recorded at other times, probes or nodes");
    if (history.time.size() < 2)
        throw std::invalid_argument("cannot compare histories of less than two records");
    const auto num_records = static_cast<int>(reference.time.size());
    const int num_probes = static_cast<int>(reference.displacement.size()) / num_records;
    double difference = 0.0, own = 0.0, total = 0.0;
    for (std::size_t k = 0; k < reference.displacement.size(); ++k) {
        difference += (history.displacement[k] - reference.displacement[k]).squaredNorm();
        own += history.displacement[k].squaredNorm();
        total += reference.displacement[k].squaredNorm();
    }
    HistoryComparison result{.reference = reference_name,
                             .relative_l2 = std::sqrt(difference / total),
                             .amplitude_error = std::sqrt(own / total) - 1.0};
    result.error.reserve(history.frames.size());
    for (std::size_t i = 0; i < history.frames.size(); ++i)
        result.error.emplace_back(history.frames[i] - reference.frames[i]);
    if (!std::isfinite(result.relative_l2)) {
        result.lag = std::numeric_limits<double>::quiet_NaN();
        return result;
    }

    /// Correlation when the history is taken this many records later.
    const auto correlation = [&](int shift) {
        double product = 0.0, mine = 0.0, theirs = 0.0;
        for (int k = std::max(0, -shift); k < std::min(num_records, num_records - shift); ++k)
            for (int q = 0; q < num_probes; ++q) {
                const auto &u = history.displacement[(k + shift) * num_probes + q];
                const auto &r = reference.displacement[k * num_probes + q];
                product += u.dot(r);
                mine += u.squaredNorm();
                theirs += r.squaredNorm();
            }
        return mine > 0.0 && theirs > 0.0 ? product / std::sqrt(mine * theirs) : 0.0;
    };
    const int largest = num_records / 4;
    // Uphill from where they are: a motion that is periodic is as much alike a period later.
    int best = 0;
    for (const int direction : {1, -1})
        while (std::abs(best) < largest && correlation(best + direction) > correlation(best))
            best += direction;
    const double left = correlation(best - 1), middle = correlation(best), right = correlation(best + 1);
    const double curvature = left - 2.0 * middle + right;
    const double part = curvature < 0.0 ? std::clamp(0.5 * (left - right) / curvature, -0.5, 0.5) : 0.0;
    result.lag = (best + part) * (reference.time[1] - reference.time[0]);
    return result;
}

} // namespace livermark::core
