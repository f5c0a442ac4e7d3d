#include "results/records/calibration.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "results/hdf5/file_parts.hpp"

namespace livermark::results {

namespace {

/// A number of each spring, positive and finite.
template <class At>
void describe_of_springs(At at, const std::string &name, hdf5::Of<At, std::vector<double>> &values,
                         const std::string &units, std::size_t num_springs) {
    at.rows(name, values, units, num_springs);
    const auto bad = std::ranges::find_if(values, [](double value) { return !(value > 0.0 && std::isfinite(value)); });
    if (bad != values.end())
        at.check(false, name,
                 fmt::format("row {} is {}, which is not positive and finite", bad - values.begin(), *bad));
}

template <class At> void describe_calibration(At root, hdf5::Of<At, Calibration> &calibration) {
    root.check(root.has("springs"), "holds no calibration");
    root.text("body", calibration.body);
    root.text("spring_law", calibration.spring_law);
    root.text("volume_term", calibration.volume_term);
    root.text("reference", calibration.reference);
    root.text("held", calibration.constrained);
    root.integer("seed", calibration.seed);
    root.integer("iterations", calibration.iterations);
    root.number("penalty", calibration.penalty);
    auto &springs = calibration.springs;
    hdf5::describe_materials(root, springs.materials);
    const auto at = root.group("springs");
    at.rows("edges", springs.edges);
    const auto num_springs = springs.edges.size();
    describe_of_springs(at, "rest_length", springs.rest_length, "m", num_springs);
    describe_of_springs(at, "start_stiffness", calibration.start_stiffness, "N/m", num_springs);
    describe_of_springs(at, "stiffness", springs.stiffness, "N/m", num_springs);
    const auto loads = root.group("loads");
    loads.rows("held_out", calibration.held_out);
    loads.rows("error_before", calibration.error_before, "", calibration.held_out.size());
    loads.rows("error_after", calibration.error_after, "", calibration.held_out.size());
}

} // namespace

void write_calibration(const std::filesystem::path &path, const Calibration &calibration) {
    hdf5::write_record(path, calibration, [](auto root, auto &record) { describe_calibration(root, record); });
}

Calibration read_calibration(const std::filesystem::path &path) {
    auto calibration = hdf5::read_record<Calibration>(
        path, "python3 -m livermark.calibration", [](auto root, auto &record) { describe_calibration(root, record); });
    calibration.springs.origin = path.string();
    return calibration;
}

} // namespace livermark::results
