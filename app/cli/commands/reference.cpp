#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "app/cli/commands/commands.hpp"
#include "app/cli/common_options.hpp"
#include "app/cli/image_bodies.hpp"
#include "app/cli/progress.hpp"
#include "core/support/input_error.hpp"
#include "results/tables/table_layout.hpp"
#include "studies/run/problems.hpp"
#include "studies/run/solutions.hpp"

namespace livermark::cli {

namespace {

struct ReferenceOptions {
    std::vector<std::string> bodies, load_cases, models;
    std::vector<double> poisson_ratios;
    std::string folder;
    bool only_check = false;
};

/// A solution that differs by more from the stored one is another: a thousandth of the discretisation error.
constexpr double largest_difference = 1e-5;

/// Those that one of the models is stored of, as runs solve them: scaled to their targets.
std::vector<core::Problem> problems_to_keep(const ReferenceOptions &options, const std::vector<core::Model> &models) {
    std::vector<core::Problem> problems;
    const auto read = [&](const meshes::MaterialOverride &material) {
        auto set = studies::read_problems(options.bodies, options.load_cases, material);
        for (auto &problem : set.problems)
            if (std::ranges::any_of(models, [&](const auto &model) { return studies::is_stored(model, problem); }))
                problems.push_back(studies::scaled_to_target(std::move(problem)));
    };
    if (options.poisson_ratios.empty())
        read({});
    for (const double ratio : options.poisson_ratios)
        read({{}, ratio});
    return problems;
}

/// The command that makes the one file again, wherever it is and whatever it was made with.
std::string command_that_stores(const ReferenceOptions &options, const core::Model &model,
                                const core::Problem &problem) {
    auto command = fmt::format("livermark reference --body {} --load-case {} --model {}", problem.body->name,
                               problem.load_case.name, model.name);
    if (!options.poisson_ratios.empty())
        command += fmt::format(" --poisson {:g}", problem.body->materials.front().poisson_ratio);
    return command;
}

int solve_all(const ReferenceOptions &options) {
    auto models = studies::models_to_keep();
    if (!options.models.empty())
        std::erase_if(models, [&](const core::Model &model) {
            return std::ranges::find(options.models, model.name) == options.models.end();
        });
    const auto problems = problems_to_keep(options, models);
    const auto progress = print_progress();
    int num_steps = 0;
    for (const auto &problem : problems)
        for (const auto &model : models)
            num_steps += studies::is_stored(model, problem) ? 1 : 0;
    studies::Steps steps(num_steps, progress);
    const auto as_text = [](double difference) {
        return std::isnan(difference) ? "-" : fmt::format("{:.1e}", difference);
    };
    results::Layout layout{{{"body"},
                            {"load case"},
                            {"model"},
                            {"from stored: L2", true},
                            {"reactions", true},
                            {"motion", true},
                            {"status"}},
                           {}};
    bool all_is_well = true;
    for (const auto &problem : problems)
        for (const auto &model : models) {
            if (!studies::is_stored(model, problem))
                continue;
            steps.next(fmt::format("{} / {} / {}", problem.body->name, problem.load_case.name, model.name));
            const auto stored = studies::solve_and_store(model, problem, options.folder, options.only_check,
                                                         command_that_stores(options, model, problem));
            const bool is_same =
                !(stored.difference > largest_difference) && !(stored.motion_difference > largest_difference);
            const bool is_known = !std::isnan(stored.difference);
            all_is_well = all_is_well && stored.status == core::SolutionStatus::ok && is_same &&
                          (is_known || !options.only_check);
            layout.rows.push_back({problem.body->name, problem.load_case.name, model.name,
                                   is_known ? as_text(stored.difference) : "not stored",
                                   as_text(stored.reaction_difference), as_text(stored.motion_difference),
                                   stored.message.empty() ? core::to_string(stored.status) : stored.message});
        }
    fmt::print("{}", results::to_text(layout));
    return all_is_well ? 0 : 1;
}

} // namespace

Command add_reference(CLI::App &parent, const std::string &command_line) {
    auto *command = parent.add_subcommand(
        "reference", "Solve and store the references on finer meshes, of large deformations and of motion, which "
                     "'livermark run' and 'livermark score' then read; seconds to minutes for each load case at rest, "
                     "longer in motion");
    auto options = std::make_shared<ReferenceOptions>();
    options->folder = studies::stored_references_folder().string();
    add_bodies(*command, options->bodies);
    command->add_option("--load-case", options->load_cases,
                        "Names as in 'livermark list load-cases', or paths; by default all");
    std::vector<std::string> names;
    for (const auto &model : studies::models_to_keep())
        names.push_back(model.name);
    command->add_option("--model", options->models, "Names of references; by default all")
        ->check(CLI::Validator(
            [names](const std::string &text) {
                return std::ranges::find(names, text) != names.end() ? std::string()
                                                                     : support::unknown_name("reference", text, names);
            },
            "NAME"));
    command
        ->add_option("--poisson", options->poisson_ratios,
                     "Poisson's ratios of every region; by default those of the bodies")
        ->delimiter(',');
    command->add_option("--folder", options->folder, "Folder of the references")->capture_default_str();
    command->add_flag("--check", options->only_check,
                      "Write nothing; exit status 1 if a solution differs from the stored one");
    return [options, command_line] {
        options->bodies = with_images_meshed(options->bodies, command_line);
        return solve_all(*options);
    };
}

} // namespace livermark::cli
