#pragma once

#include <filesystem>
#include <limits>
#include <span>
#include <string>
#include <vector>

namespace livermark::experiments {

/// A public record of a needle that was driven into bovine liver.
struct NeedleRecord {
    std::string name;
    std::string title;              ///< one line
    std::vector<std::string> files; ///< see public_data(); displacement over time before force over time
};

/// Every record of a needle, in alphabetical order.
std::span<const NeedleRecord> all_needle_records();

/// Whether all files of a record are there.
/// @param given  see data_folders()
bool is_there(const NeedleRecord &record, const std::filesystem::path &given = {});

/// Rate at which the needles of the records were driven [m/s], as far as it is published.
inline constexpr double nominal_needle_rate = 0.003;

/// A needle that stands after its way in.
struct HeldNeedle {
    double seconds = std::numeric_limits<double>::quiet_NaN();     ///< for how long
    double first_force = std::numeric_limits<double>::quiet_NaN(); ///< mean of the first twentieth of that time [N]
    double last_force = std::numeric_limits<double>::quiet_NaN();  ///< mean of the last twentieth [N]
};

/// Forces measured at the handle of a needle.
struct NeedleCurve {
    std::string name;
    std::string source;               ///< of the data: publication, and where the public files are
    std::vector<std::string> unknown; ///< sentences on what the source does not say
    double diameter = 0.0;            ///< of the needle [m]
    double stretch = 0.0;             ///< width of the stretches in which it is compared [m]
    std::vector<double> depth, force; ///< (P) way in: points in the order of the file, which may turn back [m], [N]
    std::vector<double> out_depth{}, out_force{}; ///< (Q) the same of the way out; empty where it was not recorded
    HeldNeedle held{};                            ///< NaN where it was not recorded
};

/// Reads a record of force over depth, or of displacement and force over time.
///
/// Over time, the displacement between two of its points is on a straight line, and forces outside its times are left
/// out. The way in ends where the displacement first reaches 99 % of its largest, the way out begins where it last
/// leaves that, and the needle stands between. The unit of the displacement is not known: it is as long as the rate
/// says, the mean of the way in from 10 to 90 % of the largest displacement.
/// @param given  see data_folders()
/// @param rate   of the needle on its way in, if the record is over time [m/s], > 0
/// @throws support::InputError if the data are not there (public_data()), with where to get them, or are damaged: a
///   cell that is no number, numbers of another unit, times that go back, a needle that does not go in, forces at other
///   times
NeedleCurve read_needle_curve(const NeedleRecord &record, const std::filesystem::path &given = {},
                              double rate = nominal_needle_rate);

/// The points of a stretch of the way in.
struct CurveBin {
    double from = 0.0, to = 0.0;                    ///< [m]
    double mean = 0.0, lowest = 0.0, highest = 0.0; ///< force of the points [N]
};

/// Stretches of a width from the start on, without those that have no point.
/// @param width  [m], > 0
std::vector<CurveBin> binned(const NeedleCurve &curve, double width);

/// The point at which the surface gave way: the highest before the force, in the order of the file, first falls below
/// half of it, if it is at least a third of the largest force on the way in.
struct MeasuredPuncture {
    double depth = 0.0, force = 0.0;
};
/// @throws support::InputError if there is none
MeasuredPuncture puncture_of(const NeedleCurve &curve);

/// Numbers that a record has by itself, without a model; NaN where it has none.
struct NeedlePhases {
    double touched_at = 0.0;     ///< deepest point before the puncture with less than a tenth of its force [m]
    MeasuredPuncture puncture{}; ///< the surface gives way
    double lowest = 0.0;         ///< smallest force behind the puncture: tearing takes no more [N]
    double slope = 0.0;          ///< of the line that fits the means of the stretches behind it best [N/m]
    double pull = 0.0;           ///< largest on the way out [N]
};
/// @throws support::InputError as puncture_of(), and for fewer than two stretches behind the puncture
NeedlePhases phases_of(const NeedleCurve &curve);

} // namespace livermark::experiments
