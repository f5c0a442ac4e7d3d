#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "meshes/io/body_reader.hpp"
#include "results/hdf5/files/calibration_file.hpp"
#include "studies/progress.hpp"

namespace livermark::studies {

/// Every so many loads one has no part in the fit.
inline constexpr int held_out_stride = 4;
/// After so many iterations the state is written, and L-BFGS begins anew.
inline constexpr int round_length = 20;
/// A few loads do not tell tens of thousands of stiffnesses apart: what they leave open stays as it was. The weight is
/// the square of a ratio, of the error that is worth fitting to the change that is thought likely: 1 % (the reference
/// is no better) to 30 % or so. On the healthy liver after 100 iterations, weights of 1e-2, 1e-3 and 1e-4 leave
/// held out errors of 2.36, 2.10 and 2.03 %; below 1e-3 the softest springs still get softer, for next to nothing.
inline constexpr double default_penalty = 1e-3;

/// What to fit, and how long.
struct CalibrateOptions {
    std::string body;
    std::string law = "patch";
    std::string constrained = "posterior";
    int num_loads = 24;
    std::int64_t seed = 1;
    int num_iterations = 100;
    double penalty = default_penalty;
    meshes::MaterialOverride material;
    std::string output; ///< the file; <body>.calibrated.h5 beside the body's .toml if empty
    bool restart = false;
};

/// A calibration and the file that it is in.
struct CalibrationResult {
    results::Calibration calibration;
    std::filesystem::path file;
};

/// Fits the stiffness of every spring of a body to finite elements under random loads, and goes on where an earlier
/// call with the same options stopped. The file is written after each round.
/// @param command_line  kept in the file
/// @throws support::InputError for bad input, and on several MPI ranks
CalibrationResult calibrate(const CalibrateOptions &options, const std::string &command_line,
                            const ProgressReport &report);

} // namespace livermark::studies
