#include "results/hdf5/files/stability_file.hpp"

#include "results/hdf5/file_parts.hpp"

namespace livermark::results {

namespace {

template <class At> void describe_stability(At at, hdf5::Of<At, Stability> &stability) {
    at.text("body", stability.body);
    at.text("spring_law", stability.spring_law);
    if (at.has("model")) // not in files of an older version
        at.text("model", stability.model);
    at.text("load_case", stability.load_case);
    at.number("alpha", stability.damping.alpha);
    at.number("beta", stability.damping.beta);
    at.number("lowest_angular_frequency", stability.lowest_frequency);
    at.number("largest_angular_frequency", stability.largest_frequency);
    at.number("largest_angular_frequency_bound", stability.largest_frequency_bound);
    at.number("element_time_step", stability.element_time_step);
    auto limits = hdf5::columns_of(at.group("critical_time_step"), stability.limits);
    limits.texts("integrators", &IntegratorLimits::integrator);
    limits.column(
        "undamped_predicted", [](auto &limit) -> auto & { return limit.undamped.predicted; }, "s");
    limits.column(
        "undamped_observed", [](auto &limit) -> auto & { return limit.undamped.observed; }, "s");
    limits.column(
        "damped_predicted", [](auto &limit) -> auto & { return limit.damped.predicted; }, "s");
    limits.column(
        "damped_observed", [](auto &limit) -> auto & { return limit.damped.observed; }, "s");
}

} // namespace

void write_stability(const std::filesystem::path &path, const Stability &stability) {
    hdf5::write_record(path, stability, [](auto root, auto &record) { describe_stability(root, record); });
}

Stability read_stability(const std::filesystem::path &path) {
    return hdf5::read_record<Stability>(path, "livermark stability",
                                        [](auto root, auto &record) { describe_stability(root, record); });
}

} // namespace livermark::results
