#include "app/load_scaling.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <stdexcept>

#include "core/input_error.hpp"
#include "fem_reference/mpi_session.hpp"
#include "models/model_table.hpp"

namespace livermark::app {

core::Problem scaled_to_target(core::Problem problem, const core::Model &baseline) {
    auto &load_case = problem.load_case;
    if (!load_case.scale_to_target)
        return problem;
    load_case.scale_to_target = false;
    auto at_rest = problem;
    at_rest.load_case.release.reset(); // only the static answer is wanted
    const auto solution = baseline.solve(at_rest);
    double peak = 0.0;
    for (const auto &displacement : solution.displacement)
        peak = std::max(peak, displacement.norm());
    if (solution.status != core::SolutionStatus::ok || !(peak > 0.0))
        throw std::runtime_error(fmt::format("cannot be scaled to its target: {} ends with status {} and a peak "
                                             "displacement of {} m",
                                             baseline.name, core::to_string(solution.status), peak));
    const double factor = load_case.target_peak_displacement / peak;
    load_case = core::scaled(std::move(load_case), factor);
    return problem;
}

core::Problem scaled_to_target(core::Problem problem) {
    if (!problem.load_case.scale_to_target)
        return problem;
    if (fem_reference::mpi_num_ranks() > 1)
        throw core::InputError(fmt::format("load case {} is scaled to its target, which this command cannot do on "
                                           "several ranks; start without mpirun",
                                           problem.load_case.name));
    const auto models = models::all_models();
    return scaled_to_target(std::move(problem), *std::ranges::find(models, models::baseline_model, &core::Model::name));
}

} // namespace livermark::app
