#include "studies/sensitivity/error_budget.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <limits>

#include "models/model_table.hpp"
#include "studies/files.hpp"
#include "studies/run/benchmark_case.hpp"
#include "studies/run/problems.hpp"
#include "studies/run/solutions.hpp"
#include "support/input_error.hpp"
#include "support/known_names.hpp"

namespace livermark::studies {

namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
constexpr const char *law_of_reference = "fem_p2p1_neo_hookean", *other_law = "fem_p2p1_ogden";

const results::ModelResult &reference_in(const results::Result &result) {
    const auto solved = std::ranges::find_if(result.models, [&](const results::ModelResult &model) {
        return !model.comparison && model.solution.status == core::SolutionStatus::ok;
    });
    if (solved == result.models.end())
        throw support::InputError(
            fmt::format("{} / {}: no reference finds a solution, so nothing can be compared; give "
                        "another load case",
                        result.problem.body->name, result.problem.load_case.name));
    return *solved;
}

/// The large load case of the same name; nothing where there is none, or no room for it.
std::optional<core::Problem> large_problem(const std::string &body_name, const core::Problem &nominal) {
    const auto large = "large_" + nominal.load_case.name;
    const auto all = find_toml_files({}, load_cases_folder, "load case");
    if (std::ranges::none_of(all, [&](const auto &file) { return file.stem() == large; }))
        return std::nullopt;
    try {
        return read_scaled_problems({body_name}, large, {}).problems.front();
    } catch (const support::InputError &) { // it does not fit this body
        return std::nullopt;
    }
}

std::vector<double> difference_of_laws(const core::Problem &large, const std::vector<Output> &outputs, Steps &steps) {
    auto models = models::all_models();
    std::erase_if(models,
                  [](const core::Model &model) { return model.name != law_of_reference && model.name != other_law; });
    PreparedModels prepared{SolutionCache(stored_references_folder())};
    const auto values = [&](const char *name) {
        steps.next(fmt::format("{} / {} / {}", large.body->name, large.load_case.name, name));
        return values_of(outputs, large, large, prepared.solve(support::find_named(models, name, "model"), large));
    };
    const auto of_reference = values(law_of_reference);
    return relative_differences(outputs, values(other_law), of_reference);
}

} // namespace

int num_budget_steps(const BudgetOptions &options) {
    const int num_references = options.reference_on_mesh ? 1 : 2, num_laws = options.without_law ? 0 : 2;
    return static_cast<int>(options.compared.size()) + num_references + num_laws;
}

Budget budget_of(const std::string &body_name, const core::Problem &nominal, const std::vector<Output> &outputs,
                 const BudgetOptions &options, Steps &steps) {
    const auto models = choose_models(options.compared, {}, !options.reference_on_mesh);
    const auto result =
        evaluate(nominal, models,
                 [&](const core::Model &model, const core::Problem &problem) {
                     steps.next(fmt::format("{} / {} / {}", problem.body->name, problem.load_case.name, model.name));
                     return model.solve(problem);
                 },
                 {});
    const auto &reference = reference_in(result);
    Budget found;
    auto &budget = found.budget;
    budget.reference = reference.name;
    found.reference = values_of(outputs, nominal, nominal, reference.solution);
    const auto &bar = result.reference_uncertainty;
    for (std::size_t o = 0; o < outputs.size(); ++o) {
        const bool is_stiffness = outputs[o] == Output::stiffness_at_tool;
        budget.mesh.push_back(!bar ? unknown : is_stiffness ? bar->stiffness.value_or(unknown) : bar->relative_l2);
        budget.measurement.push_back(is_stiffness || !options.displacement_noise
                                         ? unknown
                                         : *options.displacement_noise / found.reference.values[o]);
    }
    for (const auto &name : options.compared) {
        const auto &model = support::find_named(result.models, name, "model that takes part here");
        budget.models.push_back(
            {name,
             relative_differences(outputs, values_of(outputs, nominal, nominal, model.solution), found.reference)});
    }
    const auto large = options.without_law ? std::nullopt : large_problem(body_name, nominal);
    budget.law = large ? difference_of_laws(*large, outputs, steps) : std::vector<double>(outputs.size(), unknown);
    return found;
}

} // namespace livermark::studies
