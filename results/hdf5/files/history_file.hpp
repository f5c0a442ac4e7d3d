#pragma once

#include <filesystem>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "results/records/result.hpp"

namespace livermark::results {

/// How something moved in steps of one length.
struct StepHistory {
    double time_step = 0.0;                                        ///< [s]
    std::vector<double> time;                                      ///< (K) [s]
    std::vector<double> displacement;                              ///< (K) [m]
    double diverged_at = std::numeric_limits<double>::quiet_NaN(); ///< when it left all bounds [s]; NaN if it did not
};

/// One and the same motion in steps of different lengths.
struct HistoryCase {
    std::string name;  ///< no '/' and no '.'
    std::string title; ///< one line
    /// What was moved: mass [kg], stiffness [N/m] and damping [N s/m] of one degree of freedom, alpha [1/s] and beta
    /// [s] of a body; under these names.
    std::vector<std::pair<std::string, double>> parameters;
    double critical_time_step = 0.0; ///< predicted [s]
    std::vector<StepHistory> steps;
};

struct Histories {
    Provenance provenance;
    std::string subject; ///< name of the body, or one_degree_of_freedom
    std::string integrator;
    std::vector<HistoryCase> cases;
};

/// Writes the "history files" of results/schema.md, as write_result() writes results.
/// @throws support::InputError if the place cannot be written to
void write_histories(const std::filesystem::path &path, const Histories &histories);

/// Reads what write_histories wrote. Every motion has at least one record.
/// @throws support::InputError that names the file and the dataset or attribute, and says what is wrong and what to do
Histories read_histories(const std::filesystem::path &path);

} // namespace livermark::results
