#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/rayleigh_damping.hpp"
#include "msm/kernels/fast_steps.hpp"
#include "python/bindings/springs.hpp"

namespace livermark::python {

/// What a Simulation is asked for; see its docstring.
struct StepChoice {
    double time_step = 0.0; ///< h [s]
    std::string integrator;
    core::RayleighDamping damping;
    std::string kernel;
    int num_threads = 1;
    bool force_time_step = false; ///< take it even if it is too long to be stable
    core::PronySeries relaxation{};
};

/// @param branches  modulus and time [s] of each
/// @throws support::InputError if a modulus is negative, all together leave nothing, or a time is not positive
core::PronySeries prony_series(const std::vector<std::pair<double, double>> &branches);

/// Threads that simulations have beside those that call them. They are given back when it goes.
class BorrowedThreads {
  public:
    /// @param num_threads  of one simulation, that which calls it among them
    /// @throws support::InputError if they are fewer than one, too many for this machine, or too many with those of all
    /// other simulations of this process
    explicit BorrowedThreads(int num_threads);
    ~BorrowedThreads();
    BorrowedThreads(const BorrowedThreads &) = delete;
    BorrowedThreads &operator=(const BorrowedThreads &) = delete;

  private:
    int num_borrowed_;
};

/// @param fixed, forces  see conditions_of()
/// @throws support::InputError if the step is too long to be stable, and what else is wrong in the arguments
msm::FastSteps prepare_steps(const Springs &springs, const StepChoice &choice, const py::handle &fixed,
                             const py::handle &forces);

} // namespace livermark::python
