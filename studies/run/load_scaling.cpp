#include "studies/run/load_scaling.hpp"

#include <algorithm>
#include <charconv>
#include <fmt/format.h>
#include <stdexcept>
#include <utility>

#include "models/model_table.hpp"
#include "studies/run/benchmark_case.hpp"
#include "support/input_error.hpp"
#include "support/processes/mpi_session.hpp"

namespace livermark::studies {

namespace {

/// Six, so that machines whose arithmetic differs in the last digits of the baseline have the same load, and find
/// references that another one has stored.
double with_few_digits(double factor) {
    const auto digits = fmt::format("{:.5e}", factor);
    std::from_chars(digits.data(), digits.data() + digits.size(), factor);
    return factor;
}

} // namespace

core::Problem scaled_to_target(core::Problem problem, const core::Model &baseline, PreparedModels &prepared) {
    auto &load_case = problem.load_case;
    if (!load_case.scale_to_target)
        return problem;
    load_case.scale_to_target = false;
    auto at_rest = problem;
    at_rest.load_case = core::without_time(std::move(at_rest.load_case)); // only the static solution is wanted
    const auto solution = prepared.solve(baseline, at_rest);
    double peak = 0.0;
    for (const auto &displacement : solution.displacement)
        peak = std::max(peak, displacement.norm());
    if (solution.status != core::SolutionStatus::ok || !(peak > 0.0))
        throw std::runtime_error(fmt::format("cannot be scaled to its target: {} ends with status {} and a peak "
                                             "displacement of {} m",
                                             baseline.name, core::to_string(solution.status), peak));
    load_case = core::scaled(std::move(load_case), with_few_digits(load_case.target_peak_displacement / peak));
    return problem;
}

core::Problem scaled_to_target(core::Problem problem) {
    if (!problem.load_case.scale_to_target)
        return problem;
    if (support::mpi_num_ranks() > 1)
        throw support::InputError(fmt::format("load case {} is scaled to its target, which this command cannot do on "
                                              "several ranks; start without mpirun",
                                              problem.load_case.name));
    PreparedModels prepared;
    return scaled_to_target(std::move(problem), baseline_of(models::all_models()), prepared);
}

} // namespace livermark::studies
