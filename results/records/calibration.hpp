#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/model.hpp"
#include "results/records/result.hpp"

namespace livermark::results {

/// Springs fitted to the solutions of another model, and how well.
struct Calibration {
    Provenance provenance;
    std::string body;
    std::string spring_law;      ///< the stiffnesses that it started from
    std::string volume_term;     ///< what was beside the springs
    std::string reference;       ///< the model whose solutions they were fitted to
    std::string constrained;     ///< the patch where the body was constrained
    std::int64_t seed = 0;       ///< of the random loads
    std::int64_t iterations = 0; ///< so far
    double penalty = 0.0;        ///< weight of the change of the stiffnesses
    core::CalibratedSprings springs;
    std::vector<double> start_stiffness; ///< (S) [N/m]
    std::vector<std::uint8_t> held_out;  ///< (L) 1 for a load that had no part in the fit, else 0
    std::vector<double> error_before;    ///< (L) relative L2 error of each load's solution
    std::vector<double> error_after;     ///< (L)
};

/// The "Calibration files" of results/schema.md; errors as of write_result() and read_result(). Those of users are
/// written by python/livermark/calibration/; its test compares the two.
void write_calibration(const std::filesystem::path &path, const Calibration &calibration);
Calibration read_calibration(const std::filesystem::path &path);

} // namespace livermark::results
