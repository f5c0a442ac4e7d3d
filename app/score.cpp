#include <fmt/format.h>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "app/commands.hpp"
#include "app/contest.hpp"
#include "app/output.hpp"
#include "app/problems.hpp"
#include "app/progress.hpp"
#include "app/run_tables.hpp"
#include "core/input_error.hpp"
#include "core/root_folder.hpp"
#include "exchange/answer.hpp"
#include "results/error_bands.hpp"
#include "results/provenance.hpp"
#include "results/result_file.hpp"

namespace livermark::app {

namespace {

struct ScoreOptions {
    std::string body;
    std::string load_case;
    std::string answer;
    std::string name = "mine";
    std::vector<std::string> models{std::string(models::baseline_model)};
    std::string output;
    bool no_uncertainty = false;
    bool markdown = false;
};

/// A model that has answered already. It says nothing about forces, energy and time.
core::Model answered(const ScoreOptions &options, const std::vector<core::Vector3> &displacement) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    return {.name = options.name,
            .summary = "node displacements of " + options.answer,
            .source = "not ours",
            .solve = [=](const core::Problem &problem) {
                core::Solution solution;
                solution.displacement = displacement;
                solution.reaction.assign(problem.load_case.constraint_names.size(), core::Vector3::Constant(nan));
                solution.strain_energy = nan;
                solution.setup_seconds = solution.solve_seconds = nan;
                solution.degrees_of_freedom = static_cast<std::int64_t>(3 * displacement.size());
                return solution;
            }};
}

int score(const ScoreOptions &options, const std::string &command_line) {
    auto models = choose_models(options.models, {}, !options.no_uncertainty);
    for (const auto &model : models)
        if (model.name == options.name)
            throw core::InputError(fmt::format("there is a model '{}' already; choose another --name", options.name));
    const auto problem = read_scaled_problems({options.body}, options.load_case, {}).front();
    if (problem.load_case.release)
        throw core::InputError(fmt::format("load case {} depends on time, and node displacements are one moment; score "
                                           "its static start, the load case of the same loads",
                                           problem.load_case.name));
    models.push_back(answered(options, exchange::displacement_at_nodes(exchange::read_answer(options.answer),
                                                                       problem.body->mesh, options.answer)));
    const auto folder = make_output_folder(options.output, problem);
    std::vector<results::Result> results;
    {
        Progress progress(static_cast<int>(models.size()));
        results.push_back(hold_contest(problem, models, {}, results::current_provenance(command_line),
                                       [&](const std::string &model) { progress.next(model); }));
    }
    const auto file = folder / fmt::format("{}.{}.h5", problem.load_case.name, options.name);
    results::write_result(file, results.front());
    print_tables(results, TableKind::models, options.markdown);
    fmt::print(stderr, "The result file is {}\n", file.string());
    return 0;
}

/// Names stand in paths of the result file.
std::string check_name(const std::string &name) {
    const bool is_good = !name.empty() && name.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                                                 "0123456789_-") == std::string::npos;
    return is_good ? "" : "a name has letters, digits, _ and - only";
}

} // namespace

Command add_score(CLI::App &parent, const std::string &command_line) {
    auto *command = parent.add_subcommand("score", "Compare the displacements that a model outside of this suite finds "
                                                   "for a problem of 'livermark export' with the reference");
    auto options = std::make_shared<ScoreOptions>();
    options->output = (core::root_folder() / "results" / "scores").string();
    command->add_option("body", options->body, "As for 'livermark export'")->required();
    command->add_option("load-case", options->load_case, "As for 'livermark export'")->required();
    command
        ->add_option("answer", options->answer,
                     "Node displacements [m]: CSV with the header x,y,z,ux,uy,uz, HDF5 with the datasets points and "
                     "displacement, or VTU with the point data displacement; in any order")
        ->required();
    command->add_option("--name", options->name, "Of the model, in table and result file")
        ->check(CLI::Validator(check_name, "NAME"))
        ->capture_default_str();
    command->add_option("--model", options->models, "Models to stand beside it, as in 'livermark list models'")
        ->capture_default_str();
    command->add_option("--output", options->output, "Folder for <body>/<load case>.<name>.h5")->capture_default_str();
    command->add_flag("--no-uncertainty", options->no_uncertainty,
                      "Do not solve the reference on the refined mesh: quicker, but nobody knows how good it is");
    command->add_flag("--markdown", options->markdown, "Print the table in Markdown");
    return [options, command_line] { return score(*options, command_line); };
}

} // namespace livermark::app
