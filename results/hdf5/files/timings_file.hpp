#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "results/records/result.hpp"

namespace livermark::results {

/// How long one benchmark took.
struct Timing {
    std::string name;                       ///< its parts behind each other with '/' between, no '.'
    std::vector<double> seconds;            ///< (R) of an iteration in each repetition, at least one [s]
    bool is_wall_clock = false;             ///< else the time of the processor
    std::int64_t iterations = 0;            ///< in each repetition
    std::map<std::string, double> counters; ///< by name, SI units; the median of the repetitions
};

/// What one run of a benchmark program measured.
struct Timings {
    Provenance provenance;
    std::vector<Timing> timings; ///< names unique, and none the first parts of another
};

/// Writes the "timing files" of results/schema.md, as write_result() writes results.
/// @throws support::InputError if the place cannot be written to
void write_timings(const std::filesystem::path &path, const Timings &timings);

/// Reads what write_timings wrote.
/// @throws support::InputError that names the file and the dataset or attribute, and says what is wrong and what to do
Timings read_timings(const std::filesystem::path &path);

} // namespace livermark::results
