#include "experiments/needle_curve.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <map>

#include "experiments/experiment.hpp"
#include "experiments/marker_table.hpp"
#include "support/input_error.hpp"

namespace livermark::experiments {

namespace {

constexpr const char *curve_file = "needle/depth_force.csv";
constexpr const char *curve_source =
    "Okamura, Simone, O'Leary 2004, IEEE Trans. Biomed. Eng. 51; the points of a figure "
    "in github.com/amartsop/dataset_lib";
constexpr double gauge_18 = 0.00127; ///< [m]
/// Nobody drives a needle that far, or pushes a biopsy needle so.
constexpr double deepest = 0.5, strongest = 100.0;
/// Of the force before, of a surface that gave way.
constexpr double of_puncture = 0.5;

} // namespace

bool has_needle_curve() {
    std::error_code ignored;
    return std::filesystem::exists(data_folder() / curve_file, ignored);
}

NeedleCurve read_needle_curve() {
    const auto file = data_folder() / curve_file;
    if (!has_needle_curve())
        throw support::InputError(fmt::format("{}: the measured needle is not there; get it from {}, as lines of depth "
                                              "[m] and force [N], and put it there or say in LIVERMARK_EXPERIMENTS "
                                              "which folder {} is in",
                                              file.string(), curve_source, curve_file));
    NeedleCurve curve{.source = curve_source,
                      .unknown = {"how large the liver was, how it was held, and how stiff it was",
                                  "where in it the needle went, and what vessels and septa were on the way"},
                      .diameter = gauge_18,
                      .depth = {},
                      .force = {}};
    for (const auto &row : read_csv(file)) {
        if (row.cells.size() != 2)
            throw support::InputError(
                fmt::format("{}: the line has {} cells and not 2; correct it", row.place, row.cells.size()));
        const double depth = number_in(row, 0), force = number_in(row, 1);
        if (!(depth >= -1e-3 && depth < deepest && std::abs(force) < strongest))
            throw support::InputError(fmt::format("{}: {:g} m and {:g} N are no depth and force of a needle; give them "
                                                  "in SI units",
                                                  row.place, depth, force));
        curve.depth.push_back(depth);
        curve.force.push_back(force);
    }
    if (curve.depth.empty())
        throw support::InputError(fmt::format("{}: there are no points; take the public file", file.string()));
    return curve;
}

std::vector<CurveBin> binned(const NeedleCurve &curve, double width) {
    std::map<int, std::vector<double>> of_bin;
    for (std::size_t p = 0; p < curve.depth.size(); ++p)
        of_bin[static_cast<int>(std::max(0.0, curve.depth[p]) / width)].push_back(curve.force[p]);
    std::vector<CurveBin> bins;
    for (const auto &[number, forces] : of_bin) {
        double sum = 0.0;
        for (const double force : forces)
            sum += force;
        bins.push_back({number * width, (number + 1) * width, sum / static_cast<double>(forces.size()),
                        *std::ranges::min_element(forces), *std::ranges::max_element(forces)});
    }
    return bins;
}

MeasuredPuncture puncture_of(const NeedleCurve &curve, double width) {
    double highest = 0.0;
    for (const auto &bin : binned(curve, width)) {
        // Before the surface is pressed at all there is nothing but noise.
        if (bin.highest < of_puncture * highest && highest > 0.0) {
            const auto at = std::ranges::find(curve.force, highest) - curve.force.begin();
            if (highest >= of_puncture * *std::ranges::max_element(curve.force))
                return {curve.depth[static_cast<std::size_t>(at)], highest};
        }
        highest = std::max(highest, bin.highest);
    }
    throw support::InputError("the measured needle never falls to half of what it was; there is no puncture to compare "
                              "with, take the public file");
}

} // namespace livermark::experiments
