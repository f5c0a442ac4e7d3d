#include "python/bindings/prepared_steps.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <system_error>
#include <thread>

#include "msm/dynamics/time_step.hpp"
#include "msm/integrator.hpp"
#include "python/bindings/conditions.hpp"
#include "support/input_error.hpp"

namespace livermark::python {

namespace {

/// Of one simulation: more than cores only wait for each other. Small machines may try what large ones do.
int most_threads() {
    constexpr int at_least = 8;
    return std::max(at_least, 2 * static_cast<int>(std::thread::hardware_concurrency()));
}

/// Of all simulations together, beside the threads that call them.
int most_borrowed() {
    return 32 * most_threads();
}

int num_borrowed_in_all = 0; // looked at by the thread that holds the interpreter

msm::ForcePrecision precision_of(const std::string &kernel) {
    if (kernel == "simd_double")
        return msm::ForcePrecision::double_precision;
    if (kernel == "simd_float")
        return msm::ForcePrecision::single_precision;
    throw support::InputError(fmt::format("there is no kernel '{}'; known are: simd_double, simd_float", kernel));
}

/// In the words of `livermark run`.
void refuse_unstable(const Springs &springs, const StepChoice &choice, const msm::Integrator &integrator,
                     const py::handle &fixed) {
    const double highest = largest_frequency(springs, fixed);
    if (!(highest > 0.0))
        return; // nothing moves
    const double critical =
        msm::critical_time_step(integrator, choice.damping, msm::lowest_damped_part * highest, highest);
    if (!(critical > 0.0))
        throw support::InputError(fmt::format("integrator: {} is unstable at every time step with such damping; give "
                                              "more of it, take another integrator, or force_time_step=True to see "
                                              "what happens",
                                              integrator.name));
    if (choice.time_step > critical)
        throw support::InputError(fmt::format(
            "time_step: {:.3g} s is too long for {} with these springs: {:.3g} s is the longest that is stable, and "
            "{:.3g} s is safe; take that, or force_time_step=True to see what happens",
            choice.time_step, integrator.name, critical, msm::default_safety_factor * critical));
}

} // namespace

BorrowedThreads::BorrowedThreads(int num_threads) : num_borrowed_(num_threads - 1) {
    if (num_threads < 1)
        throw support::InputError(fmt::format("num_threads: {}; there has to be one at least", num_threads));
    if (num_threads > most_threads())
        throw support::InputError(
            fmt::format("num_threads: {} is too many for the {} cores of this machine; give {} at "
                        "most",
                        num_threads, std::thread::hardware_concurrency(), most_threads()));
    if (num_borrowed_in_all + num_borrowed_ > most_borrowed())
        throw support::InputError(
            fmt::format("num_threads: all simulations that are alive have {} threads already, and "
                        "{} are the most; delete some, or give num_threads=1",
                        num_borrowed_in_all, most_borrowed()));
    num_borrowed_in_all += num_borrowed_;
}

BorrowedThreads::~BorrowedThreads() {
    num_borrowed_in_all -= num_borrowed_;
}

core::PronySeries prony_series(const std::vector<std::pair<double, double>> &branches) {
    core::PronySeries series;
    for (const auto &[modulus, time] : branches) {
        if (!(modulus >= 0.0))
            throw support::InputError(fmt::format("relaxation: {} is no part of a modulus that fades; give pairs of a "
                                                  "modulus, 0 or more, and a time in seconds",
                                                  modulus));
        if (!(time > 0.0))
            throw support::InputError(
                fmt::format("relaxation: a time is {} s; times have to be positive, in seconds", time));
        series.moduli.push_back(modulus);
        series.times.push_back(time);
    }
    if (!(series.remaining() > 0.0))
        throw support::InputError(
            fmt::format("relaxation: the moduli are parts that fade, and their sum {:g} has to be "
                        "below 1; change them",
                        1.0 - series.remaining()));
    return series;
}

msm::FastSteps prepare_steps(const Springs &springs, const StepChoice &choice, const py::handle &fixed,
                             const py::handle &forces) {
    const msm::FastStepOptions options{
        .precision = precision_of(choice.kernel), .num_threads = choice.num_threads, .relaxation = choice.relaxation};
    const auto conditions = conditions_of(springs, fixed, forces);
    if (!(choice.time_step > 0.0 && std::isfinite(choice.time_step)))
        throw support::InputError(fmt::format(
            "time_step: {} s; it has to be positive, such as 0.8 of critical_time_step()", choice.time_step));
    const auto &integrator = msm::find_integrator(choice.integrator);
    if (!choice.force_time_step)
        refuse_unstable(springs, choice, integrator, fixed);
    try {
        const auto steps = msm::FastSteps::prepare(springs.body, springs.points, conditions, choice.damping,
                                                   integrator.name, choice.time_step, options);
        if (!steps)
            throw support::InputError(fmt::format("integrator: the fast kernels do not know {} for such springs; take "
                                                  "another one of integrators()",
                                                  integrator.name));
        return *steps;
    } catch (const std::system_error &error) {
        throw support::InputError(fmt::format("num_threads: the system starts no {} threads ({}); give fewer",
                                              choice.num_threads, error.code().message()));
    }
}

} // namespace livermark::python
