#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "results/records/result.hpp"

namespace livermark::results {

/// Times of one benchmark.
struct Timing {
    std::string name;                       ///< its parts behind each other with '/' between, no '.'
    std::vector<double> seconds;            ///< (R) of an iteration in each repetition, at least one [s]
    bool is_wall_clock = false;             ///< else the time of the processor
    std::int64_t iterations = 0;            ///< in each repetition
    std::map<std::string, double> counters; ///< by name, SI units; the median of the repetitions
};

/// Measurements of one run of a benchmark program.
struct Timings {
    Provenance provenance;
    std::vector<Timing> timings; ///< names unique, and none the first parts of another
};

/// The "Timing files" of results/schema.md; errors as of write_result() and read_result().
void write_timings(const std::filesystem::path &path, const Timings &timings);
Timings read_timings(const std::filesystem::path &path);

} // namespace livermark::results
