#include "core/error_norms.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <span>
#include <stdexcept>
#include <utility>

#include "core/mesh/places.hpp"

namespace livermark::core {

namespace {

void check_comparable(const TetraMesh &mesh, const LoadCase &load_case, const Solution &solution,
                      const Solution &reference, const std::string &reference_name) {
    if (reference.status != SolutionStatus::ok)
        throw std::invalid_argument(fmt::format("the reference {} is {}; there is nothing to compare with",
                                                reference_name, to_string(reference.status)));
    if (solution.displacement.size() != mesh.points.size() || reference.displacement.size() != mesh.points.size())
        throw std::invalid_argument(fmt::format("cannot compare {} and {} node displacements on a mesh of {} nodes",
                                                solution.displacement.size(), reference.displacement.size(),
                                                mesh.points.size()));
    if (solution.reaction.size() != reference.reaction.size() ||
        std::cmp_less(solution.reaction.size(), load_case.num_constraints()))
        throw std::invalid_argument(
            fmt::format("cannot compare {} reactions with {}", solution.reaction.size(), reference.reaction.size()));
}

/// max() that lets a NaN through: std::max(x, NaN) would hide one.
double max_or_nan(double a, double b) {
    return std::isnan(a) || std::isnan(b) ? std::numeric_limits<double>::quiet_NaN() : std::max(a, b);
}

constexpr double no_ratio = std::numeric_limits<double>::quiet_NaN();

/// Below this part of a force that would do the work of the load case on its peak displacement, reactions are rounding.
constexpr double smallest_reaction = 1e-6;

/// Below this part of the farthest that it comes on its way, the reference is at rest: what is compared with it there
/// is rounding over rounding.
constexpr double smallest_motion = 1e-6;

template <class Vector> double peak_of(const std::vector<Vector> &displacement) {
    double peak = 0.0;
    for (const auto &u : displacement)
        peak = max_or_nan(peak, u.template cast<double>().norm());
    return peak;
}

/// Sizes of what a reference does on its way and at its end.
struct Scale {
    double displacement = 0.0; ///< the largest [m]
    double force = 0.0;        ///< the largest that would do the stored work on the peak displacement [N]

    bool is_rest(double peak) const { return !(peak > smallest_motion * displacement); }
};

Scale scale_of(const LoadCase &load_case, const Solution &reference) {
    std::vector<std::pair<double, double>> states{{peak_of(reference.displacement), reference.strain_energy}};
    for (const auto &point : reference.path)
        states.emplace_back(peak_of(point.displacement), point.strain_energy);
    Scale scale{.displacement = load_case.contact_depth()};
    for (const auto &[peak, energy] : states)
        scale.displacement = std::max(scale.displacement, peak);
    for (const auto &[peak, energy] : states)
        if (!scale.is_rest(peak))
            scale.force = std::max(scale.force, std::abs(energy) / peak);
    return scale;
}

/// @param force  of the order of what is at work [N]
double relative_reaction_error(std::span<const Vector3> reaction, std::span<const Vector3> reference, double force) {
    double difference = 0.0;
    double total = 0.0;
    for (std::size_t p = 0; p < reference.size(); ++p) {
        difference += (reaction[p] - reference[p]).squaredNorm();
        total += reference[p].squaredNorm();
    }
    if (!(std::sqrt(total) > smallest_reaction * force))
        return std::numeric_limits<double>::quiet_NaN();
    return std::sqrt(difference / total);
}

double reaction_bias(std::span<const Vector3> reaction, std::span<const Vector3> reference) {
    double along = 0.0, total = 0.0;
    for (std::size_t p = 0; p < reference.size(); ++p) {
        along += reaction[p].dot(reference[p]);
        total += reference[p].squaredNorm();
    }
    return along / total - 1.0;
}

/// The distance that 95 % of the volume stay below.
double percentile_95(std::span<const Vector3> error, std::span<const double> volumes) {
    std::vector<std::pair<double, double>> distances; // and volumes
    double total = 0.0;
    for (std::size_t i = 0; i < error.size(); ++i) {
        if (!error[i].allFinite())
            return std::numeric_limits<double>::quiet_NaN();
        distances.emplace_back(error[i].norm(), volumes[i]);
        total += volumes[i];
    }
    std::ranges::sort(distances);
    double below = 0.0;
    for (const auto &[distance, volume] : distances)
        if (below += volume; below >= 0.95 * total)
            return distance;
    return distances.back().first;
}

double relative_l2(std::span<const Eigen::Vector3f> displacement, std::span<const Eigen::Vector3f> reference,
                   std::span<const double> volumes) {
    double difference = 0.0, total = 0.0;
    for (std::size_t i = 0; i < volumes.size(); ++i) {
        difference += volumes[i] * (displacement[i] - reference[i]).cast<double>().squaredNorm();
        total += volumes[i] * reference[i].cast<double>().squaredNorm();
    }
    return std::sqrt(difference / total);
}

PathComparison compare_paths(const TetraMesh &mesh, const Solution &solution, const Solution &reference,
                             const Comparison &at_end, std::span<const double> volumes, const Scale &scale) {
    PathComparison result;
    const bool ends_at_rest = scale.is_rest(peak_of(reference.displacement));
    result.reaction_bias = std::isnan(at_end.reaction_error) ? at_end.reaction_error
                                                             : reaction_bias(solution.reaction, reference.reaction);
    result.worst_reaction_error = at_end.reaction_error;
    result.worst_relative_l2 = at_end.relative_l2;
    for (std::size_t k = 0; k < std::min(solution.path.size(), reference.path.size()); ++k) {
        const auto &point = solution.path[k], &expected = reference.path[k];
        if (scale.is_rest(peak_of(expected.displacement)))
            continue;
        const double reaction_error =
            relative_reaction_error(point.reaction, expected.reaction, ends_at_rest ? scale.force : 0.0);
        const double error = relative_l2(point.displacement, expected.displacement, volumes);
        // A NaN stays where the end is no rest: without a resultant there, there is none at other fractions either.
        const bool is_first = ends_at_rest && std::isnan(result.worst_relative_l2);
        result.worst_reaction_error = ends_at_rest && std::isnan(result.worst_reaction_error)
                                          ? reaction_error
                                          : std::max(result.worst_reaction_error, reaction_error);
        result.worst_relative_l2 = is_first ? error : max_or_nan(result.worst_relative_l2, error);
    }
    result.percentile_95 = percentile_95(at_end.error, volumes);
    const auto deformed = deformation(mesh, solution.displacement);
    const auto expected = deformation(mesh, reference.displacement);
    result.volume_error = deformed.volume_change - expected.volume_change;
    for (std::size_t r = 0; r < expected.centroid.size(); ++r)
        result.centroid_error.push_back((deformed.centroid[r] - expected.centroid[r]).norm());
    return result;
}

/// A solution of the load at a point of the path.
Solution as_far_as(const Solution &solution, std::size_t num_points) {
    const auto &last = solution.path[num_points - 1];
    Solution part;
    for (const auto &displacement : last.displacement)
        part.displacement.push_back(displacement.cast<double>());
    part.reaction = last.reaction;
    part.strain_energy = last.strain_energy;
    part.path.assign(solution.path.begin(), solution.path.begin() + static_cast<std::ptrdiff_t>(num_points));
    return part;
}

/// The load case whose whole load is that at a point of the path.
LoadCase as_far_as(LoadCase load_case, std::size_t num_points) {
    const double fraction = load_case.path[num_points - 1];
    load_case = cut_short(std::move(load_case), fraction);
    load_case.path.resize(num_points);
    for (double &part : load_case.path)
        part /= fraction;
    load_case.path.back() = 1.0;
    return load_case;
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

Comparison compare(const TetraMesh &mesh, const LoadCase &load_case, const Solution &solution,
                   const Solution &reference, const std::string &reference_name) {
    check_comparable(mesh, load_case, solution, reference, reference_name);
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
    const auto scale = scale_of(load_case, reference);
    if (!std::isfinite(squared_reference))
        throw std::invalid_argument(fmt::format("the reference {} moves farther than numbers go; give the load case a "
                                                "smaller load, and check the units of its numbers and of the material",
                                                reference_name));
    if (!(squared_reference > 0.0) && !load_case.is_touched())
        throw std::invalid_argument(fmt::format(
            "the reference {} does not move, or so little that squares of it are zero; give the load case a load",
            reference_name));
    const bool is_at_rest = scale.is_rest(peak);
    const auto unless_at_rest = [&](double ratio) { return is_at_rest ? no_ratio : ratio; };
    result.relative_l2 = unless_at_rest(std::sqrt(squared_error / squared_reference));
    result.max_error_relative = unless_at_rest(result.max_error / peak);
    result.energy_error = unless_at_rest((solution.strain_energy - reference.strain_energy) / reference.strain_energy);
    result.reaction_error =
        unless_at_rest(relative_reaction_error(solution.reaction, reference.reaction, reference.strain_energy / peak));
    if (!reference.path.empty() && !load_case.slow_history)
        result.path = compare_paths(mesh, solution, reference, result, volumes, scale);
    result.slow = compare_slow_histories(mesh, load_case, solution, reference);
    result.tool = compare_at_tool(mesh, load_case, solution, reference, smallest_reaction * scale.force);
    if (is_at_rest && result.tool)
        for (auto &place : result.tool->places)
            place.stiffness = place.relative_l2 = no_ratio;
    return result;
}

std::size_t num_points_reached(const LoadCase &load_case, const Solution &reference) {
    if (reference.status == SolutionStatus::ok || load_case.slow_history)
        return 0;
    return std::min(reference.path.size(), load_case.path.size());
}

std::optional<Comparison> compare_as_far_as_reached(const TetraMesh &mesh, const LoadCase &load_case,
                                                    const Solution &solution, const Solution &reference,
                                                    const std::string &reference_name) {
    const auto num_points = num_points_reached(load_case, reference);
    if (num_points == 0 || solution.path.size() < num_points)
        return std::nullopt;
    const double fraction = load_case.path[num_points - 1];
    auto comparison = compare(mesh, as_far_as(load_case, num_points), as_far_as(solution, num_points),
                              as_far_as(reference, num_points), reference_name);
    comparison.load_fraction = fraction;
    return comparison;
}

HistoryComparison compare(const History &history, const History &reference, const std::string &reference_name) {
    const bool have_frames = !history.frames.empty() && !reference.frames.empty();
    if (history.time != reference.time || history.displacement.size() != reference.displacement.size() ||
        (have_frames && history.frames.size() != reference.frames.size()))
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
    if (have_frames) {
        result.frames_reference = reference_name;
        for (std::size_t i = 0; i < history.frames.size(); ++i)
            result.error.emplace_back(history.frames[i] - reference.frames[i]);
    }
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

double modal_assurance(const TetraMesh &mesh, std::span<const Vector3> a, std::span<const Vector3> b) {
    const auto volumes = nodal_volumes(mesh);
    double aa = 0.0, bb = 0.0, ab = 0.0;
    for (std::size_t i = 0; i < volumes.size(); ++i) {
        aa += volumes[i] * a[i].squaredNorm();
        bb += volumes[i] * b[i].squaredNorm();
        ab += volumes[i] * a[i].dot(b[i]);
    }
    return ab * ab / (aa * bb);
}

} // namespace livermark::core
