#include <algorithm>
#include <fmt/format.h>
#include <memory>

#include "app/catalogue.hpp"
#include "app/commands.hpp"
#include "app/output.hpp"
#include "app/problems.hpp"
#include "app/progress.hpp"
#include "core/input_error.hpp"
#include "core/root_folder.hpp"
#include "meshes/body_reader.hpp"
#include "models/model_table.hpp"
#include "results/modes_table.hpp"
#include "results/provenance.hpp"
#include "results/result_file.hpp"

namespace livermark::app {

namespace {

constexpr int most_modes = 1000;

struct ModesOptions {
    std::vector<std::string> bodies;
    std::string load_case = "traction";
    std::vector<std::string> models{std::string(models::baseline_model), std::string(models::moving_reference_model),
                                    "lloyd"};
    int count = 20;
    meshes::MaterialOverride material;
    std::string output;
    bool markdown = false;
};

/// The models that were named, in that order.
std::vector<core::Model> models_with_modes(const std::vector<std::string> &wanted) {
    std::vector<std::string> known;
    std::vector<core::Model> able;
    for (const auto &model : models::all_models())
        if (model.modes) {
            known.push_back(model.name);
            able.push_back(model);
        }
    std::vector<core::Model> chosen;
    for (const auto &name : wanted) {
        const auto found = std::ranges::find(able, name, &core::Model::name);
        if (found == able.end())
            throw core::InputError(unknown_name("model with modes", name, known));
        if (std::ranges::find(chosen, name, &core::Model::name) != chosen.end())
            throw core::InputError(fmt::format("model '{}' is asked for twice; name it once", name));
        chosen.push_back(*found);
    }
    return chosen;
}

int find_modes(const ModesOptions &options, const std::string &command_line) {
    const auto models = models_with_modes(options.models);
    const auto problems = read_scaled_problems(options.bodies, options.load_case, options.material);
    std::vector<results::Result> done;
    {
        Progress progress(static_cast<int>(problems.size() * models.size()));
        for (const auto &problem : problems) {
            const auto folder = make_output_folder(options.output, problem);
            results::Result result{
                .provenance = results::current_provenance(command_line), .problem = problem, .models = {}, .modes = {}};
            for (const auto &model : models) {
                progress.next(fmt::format("{} / {}", problem.body->name, model.name));
                result.modes.push_back({model.name, model.modes(problem, options.count)});
            }
            results::write_result(folder / fmt::format("modes.{}.h5", problem.load_case.name), result);
            done.push_back(std::move(result));
        }
    }
    for (const auto &result : done)
        fmt::print("{}, held as in {}\n{}\n", result.problem.body->name, result.problem.load_case.name,
                   options.markdown ? results::to_markdown(results::modes_table(result, models::moving_reference_model))
                                    : results::to_text(results::modes_table(result, models::moving_reference_model)));
    fmt::print(stderr, "Result files are in {}\n", options.output);
    return 0;
}

} // namespace

Command add_modes(CLI::App &parent, const std::string &command_line) {
    auto *command = parent.add_subcommand("modes", "Find the lowest frequencies and modes of bodies that are held");
    auto options = std::make_shared<ModesOptions>();
    options->output = (core::root_folder() / "results" / "runs").string();
    command->add_option("body", options->bodies,
                        "Names as in 'livermark list bodies', or paths of body .toml files; all that ship if none is "
                        "named");
    command->add_option("--load-case", options->load_case, "Where it is held: as this load case says")
        ->capture_default_str();
    command->add_option("--model", options->models, "Models that know their modes")->capture_default_str();
    command->add_option("--count", options->count, "How many modes")
        ->check(CLI::Range(1, most_modes))
        ->capture_default_str();
    command->add_option("--young", options->material.young_modulus,
                        "Young's modulus of the first region [Pa]; the others keep their ratio to it");
    command->add_option("--poisson", options->material.poisson_ratio, "Poisson's ratio of every region");
    command->add_option("--output", options->output, "Folder for <body>/modes.<load case>.h5")->capture_default_str();
    command->add_flag("--markdown", options->markdown, "Print the tables in Markdown");
    return [options, command_line] { return find_modes(*options, command_line); };
}

} // namespace livermark::app
