#include "studies/modes/modes.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "core/support/input_error.hpp"
#include "results/hdf5/result_file.hpp"
#include "results/records/result.hpp"
#include "studies/files.hpp"
#include "studies/run/problems.hpp"

namespace livermark::studies {

namespace {

/// The models that were named, in that order.
std::vector<core::Model> models_with_modes(const std::vector<std::string> &wanted) {
    auto able = models::all_models();
    std::erase_if(able, [](const core::Model &model) { return !model.modes; });
    std::vector<core::Model> chosen;
    for (const auto &name : wanted) {
        const auto &model = support::find_named(able, name, "model with modes");
        if (std::ranges::find(chosen, name, &core::Model::name) != chosen.end())
            throw support::InputError(fmt::format("model '{}' is asked for twice; name it once", name));
        chosen.push_back(model);
    }
    return chosen;
}

} // namespace

ModesResults find_modes(const ModesOptions &options, const std::string &command_line, const ProgressReport &report) {
    const auto models = models_with_modes(options.models);
    const auto [problems, notes, left_out] =
        read_constrained_problems(options.bodies, options.load_case, options.material);
    ModesResults found{{}, notes};
    Steps steps(static_cast<int>(problems.size() * models.size()), report);
    for (const auto &problem : problems) {
        const OutputFile file(options.output, problem, fmt::format("modes.{}.h5", problem.load_case.name));
        results::Result result{
            .provenance = results::current_provenance(command_line), .problem = problem, .models = {}, .modes = {}};
        for (const auto &model : models) {
            steps.next(fmt::format("{} / {}", problem.body->name, model.name));
            result.modes.push_back({model.name, model.modes(problem, options.count)});
        }
        results::write_result(file.path(), result);
        found.of_body.push_back(std::move(result));
    }
    return found;
}

} // namespace livermark::studies
