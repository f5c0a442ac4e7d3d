#pragma once

#include <optional>
#include <string>

namespace livermark::msm {

/// Kernels for the forces of steps in time. All give the same motion, to the digits that they have.
enum class StepKernel {
    scalar,      ///< the slow, obvious one, which knows every body and integrator
    simd_double, ///< vector units, double precision
    simd_float   ///< vector units, forces in single precision; see FastSteps
};

/// The word for a kernel in options and result files.
const char *to_string(StepKernel kernel);

/// Choices of a user about steps in time.
struct TimeStepping {
    /// A name of all_integrators(); by default runge_kutta_4 or runge_kutta_chebyshev, whichever needs fewer forces.
    std::optional<std::string> integrator{};
    /// Longest step [s], > 0; by default a safe part of the critical one. Where it is asked for, a step has the usual
    /// number of forces.
    std::optional<double> time_step{};
    bool force = false; ///< take it even if it is too long
    StepKernel kernel = StepKernel::simd_float;
};

} // namespace livermark::msm
