#include "load_cases/experiments/needle_curves.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <iterator>
#include <map>
#include <optional>
#include <utility>

#include "core/support/input_error.hpp"
#include "load_cases/experiments/experiment.hpp"
#include "load_cases/experiments/markers.hpp"

namespace livermark::experiments {

namespace {

constexpr const char *needle_source =
    "Okamura, Simone, O'Leary 2004, IEEE Trans. Biomed. Eng. 51; the points of a figure in {} of "
    "github.com/amartsop/dataset_lib";
constexpr double gauge_18 = 0.00127;       ///< [m]
constexpr double length_of_bevel = 0.0072; ///< of 10 degrees on that diameter [m]
constexpr double wide_stretch = 0.002;     ///< [m]
constexpr double num_stretches = 24.0;     ///< of a way whose length is not known
/// Nobody drives a needle that far, pushes a biopsy needle so, or records it for so long.
constexpr double deepest = 0.5, strongest = 100.0, longest = 3600.0;
/// Part of the force before, of a surface that gave way; and of the largest force, that it bore at least.
constexpr double punctured = 0.5, least_puncture = 1.0 / 3.0;
constexpr double touching = 0.1;                         ///< part of the force of the puncture
constexpr double end_of_way = 0.99;                      ///< part of the largest displacement
constexpr std::array<double, 2> parts_of_rate{0.1, 0.9}; ///< of it, between which the rate is taken
constexpr double part_of_hold = 0.05;                    ///< at either end of it
constexpr std::size_t fewest_points = 10;                ///< of a force on the way in
constexpr double most_noise = 0.02;                      ///< of a displacement, of the largest, below zero

/// Rows of a file of two columns.
/// @throws support::InputError
std::vector<std::array<double, 2>> pairs_in(const std::filesystem::path &file,
                                            const std::function<void(const CsvRow &, double, double)> &check) {
    std::vector<std::array<double, 2>> pairs;
    for (const auto &row : read_csv(file)) {
        if (row.cells.size() != 2)
            throw support::InputError("{}: the line has {} cells and not 2; correct it", row.place, row.cells.size());
        pairs.push_back({number_in(row, 0), number_in(row, 1)});
        check(row, pairs.back()[0], pairs.back()[1]);
    }
    if (pairs.empty())
        throw support::InputError("{}: there are no points; take the public file", file.string());
    return pairs;
}

/// Place of a file of a record.
/// @throws support::InputError if it is not there
std::filesystem::path place_of(const std::string &file, const NeedleRecord &record, const std::string &source,
                               const std::string &columns, const std::filesystem::path &given) {
    if (const auto place = public_data(file, given))
        return *place;
    throw support::InputError("{}: the measured needle '{}' is not there; get it from {}, as lines of {}, and {}, or "
                              "give that folder as --data",
                              file, record.name, source, columns, where_to_put(file));
}

void read_over_depth(const NeedleRecord &record, const std::filesystem::path &given, NeedleCurve &curve) {
    const auto file = place_of(record.files.front(), record, curve.source, "depth [m] and force [N]", given);
    for (const auto &[depth, force] : pairs_in(file, [](const CsvRow &row, double at, double value) {
             if (!(at >= -1e-3 && at < deepest && std::abs(value) < strongest))
                 throw support::InputError(
                     "{}: {:g} m and {:g} N are no depth and force of a needle; give them in SI units", row.place, at,
                     value);
         })) {
        curve.depth.push_back(depth);
        curve.force.push_back(force);
    }
    curve.stretch = wide_stretch;
}

/// A displacement over time, in a unit of its own.
class Displacement {
  public:
    explicit Displacement(const std::filesystem::path &file) : file_(file.string()) {
        points_ = pairs_in(file, [this](const CsvRow &row, double time, double) {
            if (!(time >= 0.0 && time < longest))
                throw support::InputError("{}: {:g} s is no time of a needle; give seconds from the start on",
                                          row.place, time);
            if (!(time > last_))
                throw support::InputError("{}: the time {:g} s is not after the one before; sort the lines, and leave "
                                          "the second of two at one time out",
                                          row.place, time);
            last_ = time;
        });
        for (const auto &point : points_)
            largest_ = std::max(largest_, point[1]);
        const double lowest = std::ranges::min_element(points_, {}, [](const auto &point) { return point[1]; })->at(1);
        if (!(largest_ > 0.0) || lowest < -most_noise * largest_ || points_.front()[1] > parts_of_rate[0] * largest_)
            throw support::InputError("{}: displacements are from {:g} to {:g} and begin with {:g}; give those of a "
                                      "needle that goes in from zero",
                                      file_, lowest, largest_, points_.front()[1]);
    }

    double first_time() const { return points_.front()[0]; } ///< [s]
    double last_time() const { return points_.back()[0]; }   ///< [s]

    /// At a time from the first to the last.
    double at(double time) const {
        const auto next = std::ranges::upper_bound(points_, time, {}, [](const auto &point) { return point[0]; });
        if (next == points_.end())
            return points_.back()[1];
        const auto &before = *std::prev(next);
        return before[1] + (time - before[0]) / ((*next)[0] - before[0]) * ((*next)[1] - before[1]);
    }

    /// The first time at which a part of the largest displacement is reached [s].
    double first_at(double part) const {
        const double level = part * largest_;
        for (std::size_t p = 1; p < points_.size(); ++p)
            if (points_[p][1] >= level)
                return crossing(points_[p - 1], points_[p], level);
        return last_time();
    }

    /// The last time at which it is left [s]; nothing if it is not.
    std::optional<double> last_at(double part) const {
        const double level = part * largest_;
        if (points_.back()[1] >= level)
            return std::nullopt;
        for (std::size_t p = points_.size() - 1; p > 0; --p)
            if (points_[p - 1][1] >= level)
                return crossing(points_[p - 1], points_[p], level);
        return std::nullopt;
    }

    /// Mean rate of the way in, per second.
    double rate() const {
        const double seconds = first_at(parts_of_rate[1]) - first_at(parts_of_rate[0]);
        if (!(seconds > 0.0))
            throw support::InputError("{}: the needle goes in at once; give the displacement at more times", file_);
        return (parts_of_rate[1] - parts_of_rate[0]) * largest_ / seconds;
    }

  private:
    static double crossing(const std::array<double, 2> &a, const std::array<double, 2> &b, double level) {
        return a[0] + (level - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
    }

    std::string file_;
    std::vector<std::array<double, 2>> points_; // time [s], displacement
    double last_ = -1.0, largest_ = 0.0;
};

/// Mean force from one time to another.
double mean_force(const std::vector<std::array<double, 2>> &forces, double from, double to) {
    double sum = 0.0;
    int count = 0;
    for (const auto &[time, force] : forces)
        if (time >= from && time <= to) {
            sum += force;
            ++count;
        }
    return count > 0 ? sum / count : std::numeric_limits<double>::quiet_NaN();
}

void read_over_time(const NeedleRecord &record, const std::filesystem::path &given, double rate, NeedleCurve &curve) {
    const auto place = [&](std::size_t file, const char *columns) {
        return place_of(record.files[file], record, curve.source, columns, given);
    };
    const Displacement displacement(place(0, "time [s] and displacement"));
    const auto file = place(1, "time [s] and force [N]");
    double last = 0.0;
    const auto forces = pairs_in(file, [&](const CsvRow &row, double time, double force) {
        if (!(time >= 0.0 && time < longest && std::abs(force) < strongest))
            throw support::InputError("{}: {:g} s and {:g} N are no time and force of a needle; give them in SI units",
                                      row.place, time, force);
        if (!(time >= last)) // steep parts of a figure have several points at a time
            throw support::InputError("{}: the time {:g} s is before the one of the line before; sort the lines",
                                      row.place, time);
        last = time;
    });
    const double metres = rate / displacement.rate();
    const double in = displacement.first_at(end_of_way);
    const auto out = displacement.last_at(end_of_way);
    for (const auto &[time, force] : forces) {
        if (time < displacement.first_time() || time > displacement.last_time())
            continue;
        const double depth = metres * displacement.at(time);
        if (!(depth < deepest))
            throw support::InputError("{}: at {:g} m/s the needle goes {:g} m deep; give a lower --rate", file.string(),
                                      rate, depth);
        if (time <= in) {
            curve.depth.push_back(depth);
            curve.force.push_back(force);
        } else if (out && time >= *out) {
            curve.out_depth.push_back(depth);
            curve.out_force.push_back(force);
        }
    }
    if (curve.depth.size() < fewest_points)
        throw support::InputError("{}: {} forces are at times from {:g} to {:g} s, at which the needle goes in, and it "
                                  "takes {}; give displacement and force of one insertion",
                                  file.string(), curve.depth.size(), displacement.first_time(), in, fewest_points);
    if (out && *out > in) {
        const double part = part_of_hold * (*out - in);
        curve.held = {*out - in, mean_force(forces, in, in + part), mean_force(forces, *out - part, *out)};
    }
    curve.stretch = (1.0 + 1e-9) * *std::ranges::max_element(curve.depth) / num_stretches; // the last has the end
    curve.unknown.push_back(fmt::format(
        "the unit of its displacement: at {:g} mm/s, as taken here, it is {:.1f} mm; if it was an inch, the "
        "needle went in at {:.1f} mm/s, and depths are to be multiplied by {:.2f}",
        1e3 * rate, 1e3 * metres, 25.4 * displacement.rate(), 0.0254 / metres));
    curve.unknown.push_back(fmt::format(
        "whether the shaft was inside: a bevel of 10 degrees is {:.1f} mm long, and the "
        "needle went {:.1f} mm from where it touched",
        1e3 * length_of_bevel, 1e3 * (*std::ranges::max_element(curve.depth) - phases_of(curve).touched_at)));
}

} // namespace

std::span<const NeedleRecord> all_needle_records() {
    static const std::vector<NeedleRecord> all{{"depth_force", "force over depth, 48 mm", {"needle/depth_force.csv"}},
                                               {"time_force",
                                                "displacement and force over time: in, held for 8 s, and out",
                                                {"needle/time_displacement.csv", "needle/time_force.csv"}}};
    return all;
}

bool is_there(const NeedleRecord &record, const std::filesystem::path &given) {
    return std::ranges::all_of(record.files,
                               [&](const std::string &file) { return public_data(file, given).has_value(); });
}

NeedleCurve read_needle_curve(const NeedleRecord &record, const std::filesystem::path &given, double rate) {
    const bool is_over_time = record.files.size() == 2;
    NeedleCurve curve{.name = record.name,
                      .source = fmt::format(needle_source, is_over_time ? "include/axial_force_dataset/share/Data1"
                                                                        : "include/axial_force_dataset/share/Data0"),
                      .unknown = {"how large the liver was, how it was held, and how stiff it was",
                                  "where in it the needle went, and what vessels and septa were on the way"},
                      .diameter = gauge_18,
                      .depth = {},
                      .force = {}};
    if (is_over_time)
        read_over_time(record, given, rate, curve);
    else
        read_over_depth(record, given, curve);
    return curve;
}

std::vector<CurveBin> binned(const NeedleCurve &curve, double width) {
    std::map<int, std::vector<double>> bin_forces;
    for (std::size_t p = 0; p < curve.depth.size(); ++p)
        bin_forces[static_cast<int>(std::max(0.0, curve.depth[p]) / width)].push_back(curve.force[p]);
    std::vector<CurveBin> bins;
    for (const auto &[number, forces] : bin_forces) {
        double sum = 0.0;
        for (const double force : forces)
            sum += force;
        bins.push_back({number * width, (number + 1) * width, sum / static_cast<double>(forces.size()),
                        *std::ranges::min_element(forces), *std::ranges::max_element(forces)});
    }
    return bins;
}

MeasuredPuncture puncture_of(const NeedleCurve &curve) {
    const double least = least_puncture * *std::ranges::max_element(curve.force);
    MeasuredPuncture highest;
    for (std::size_t p = 0; p < curve.force.size(); ++p) {
        // Before the surface is pressed at all there is nothing but noise.
        if (highest.force > 0.0 && highest.force >= least && curve.force[p] < punctured * highest.force)
            return highest;
        if (curve.force[p] > highest.force)
            highest = {curve.depth[p], curve.force[p]};
    }
    throw support::InputError("the measured needle '{}' never falls to half of what it was; there is no puncture to "
                              "compare with, take the public file",
                              curve.name);
}

NeedlePhases phases_of(const NeedleCurve &curve) {
    NeedlePhases phases{.puncture = puncture_of(curve), .lowest = std::numeric_limits<double>::infinity()};
    for (std::size_t p = 0; p < curve.depth.size(); ++p) {
        if (curve.depth[p] > phases.puncture.depth)
            phases.lowest = std::min(phases.lowest, curve.force[p]);
        else if (curve.force[p] <= touching * phases.puncture.force)
            phases.touched_at = std::max(phases.touched_at, curve.depth[p]);
    }
    // Least squares of mean = a + slope middle.
    double count = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
    for (const auto &bin : binned(curve, curve.stretch)) {
        if (bin.from < phases.puncture.depth)
            continue;
        const double middle = 0.5 * (bin.from + bin.to);
        count += 1.0;
        x += middle;
        y += bin.mean;
        xx += middle * middle;
        xy += middle * bin.mean;
    }
    if (count < 2.0)
        throw support::InputError("the measured needle '{}' ends within {:g} m of its puncture; there is nothing to "
                                  "compare behind it, take the public file",
                                  curve.name, 2.0 * curve.stretch);
    phases.slope = (count * xy - x * y) / (count * xx - x * x);
    phases.pull = curve.out_force.empty() ? std::numeric_limits<double>::quiet_NaN()
                                          : std::max(0.0, -*std::ranges::min_element(curve.out_force));
    return phases;
}

} // namespace livermark::experiments
