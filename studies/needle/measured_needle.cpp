#include "studies/needle/measured_needle.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "experiments/markers.hpp"
#include "studies/needle/insertion.hpp"
#include "studies/needle/needle_problems.hpp"
#include "support/input_error.hpp"

namespace livermark::studies {

namespace {

constexpr double stretch = 0.002; ///< [m]
/// Of the friction [N/m]: the most that is tried, and to what it is found.
constexpr double most_friction = 500.0, friction_tolerance = 0.01;
constexpr double golden = 0.6180339887498949;

/// What a model meets with a friction.
results::FittedNeedle with_friction(const Eigen::MatrixXd &compliance, const core::NeedleLine &line,
                                    core::Needle needle, double friction, const results::MeasuredNeedle &measured) {
    needle.friction = friction;
    results::FittedNeedle run;
    run.friction = friction;
    run.insertion = insert(compliance, line, needle);
    const auto &insertion = run.insertion;
    double sum = 0.0, sum_before = 0.0;
    int count = 0, count_before = 0;
    for (std::size_t b = 0; b < measured.from.size(); ++b) {
        double force = 0.0;
        int records = 0;
        for (int j = 0; j <= insertion.at_plan; ++j)
            if (insertion.depth[j] >= measured.from[b] && insertion.depth[j] < measured.to[b]) {
                force += insertion.force[j];
                ++records;
            }
        run.force.push_back(records > 0 ? force / records : std::numeric_limits<double>::quiet_NaN());
        if (records == 0)
            continue;
        const double off = run.force.back() - measured.mean[b];
        run.work += run.force.back() * (measured.to[b] - measured.from[b]);
        const bool is_before = measured.to[b] <= measured.puncture_depth;
        const bool is_behind = measured.from[b] >= measured.puncture_depth;
        (is_behind ? sum : sum_before) += is_before || is_behind ? off * off : 0.0;
        count += is_behind ? 1 : 0;
        count_before += is_before ? 1 : 0;
    }
    run.error = std::sqrt(sum / std::max(1, count));
    run.error_before = std::sqrt(sum_before / std::max(1, count_before));
    return run;
}

/// The friction of the least error, by golden section.
results::FittedNeedle fitted(const Eigen::MatrixXd &compliance, const core::NeedleLine &line,
                             const core::Needle &needle, const results::MeasuredNeedle &measured) {
    const auto at = [&](double friction) { return with_friction(compliance, line, needle, friction, measured); };
    double low = 0.0, high = most_friction;
    auto left = at(high - golden * (high - low)), right = at(low + golden * (high - low));
    while (high - low > friction_tolerance) {
        if (left.error <= right.error) {
            high = right.friction;
            right = std::move(left);
            left = at(high - golden * (high - low));
        } else {
            low = left.friction;
            left = std::move(right);
            right = at(low + golden * (high - low));
        }
    }
    return left.error <= right.error ? left : right;
}

} // namespace

results::MeasuredNeedle compare_with_measured(const NeedleOptions &options, const ProgressReport &report) {
    const auto curve = experiments::read_needle_curve();
    const auto puncture = experiments::puncture_of(curve, stretch);
    const auto models = models_with_needles(options);
    std::vector<std::string> notes;
    const auto problems = read_with_needles(options, notes);
    const auto &[problem, needles] = problems.front();
    results::MeasuredNeedle measured;
    measured.source = curve.source;
    measured.unknown = curve.unknown;
    measured.needle = needles.front();
    auto &needle = measured.needle;
    const double end = *std::ranges::max_element(curve.depth);
    if (!(needle.depth() >= end))
        throw support::InputError(fmt::format("{}: the needle '{}' goes {:.3g} m deep, and the measured one {:.3g} m; "
                                              "give a load case with a needle as deep",
                                              options.load_case, needle.name, needle.depth(), end));
    needle.target = needle.entry + end * needle.direction();
    needle.diameter = curve.diameter;
    needle.puncture_force = puncture.force;
    measured.puncture_depth = puncture.depth;
    for (const auto &bin : experiments::binned(curve, stretch)) {
        measured.from.push_back(bin.from);
        measured.to.push_back(bin.to);
        measured.mean.push_back(bin.mean);
        measured.lowest.push_back(bin.lowest);
        measured.highest.push_back(bin.highest);
        measured.work += bin.mean * (bin.to - bin.from);
    }
    const auto line = core::needle_line(needle);
    Steps steps(static_cast<int>(models.size()), report);
    for (const auto &model : models) {
        steps.next(fmt::format("{} / measured needle / {}", problem.body->name, model.name));
        const auto compliance = model.compliance(problem, line.places).matrix;
        // Before the puncture depth = F (C / stiffness + 1 / k), with C of the place at the entry.
        const core::Vector3 axis = needle.direction();
        const double of_entry = axis.dot(compliance.topLeftCorner<3, 3>() * axis);
        const double stiffness = of_entry / (puncture.depth / puncture.force - 1.0 / core::needle_stiffness);
        auto run = fitted(compliance / stiffness, line, needle, measured);
        run.model = model.name;
        run.stiffness = stiffness;
        measured.runs.push_back(std::move(run));
    }
    return measured;
}

} // namespace livermark::studies
