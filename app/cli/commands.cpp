#include "app/cli/commands.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <map>
#include <memory>
#include <sstream>
#include <string_view>
#include <system_error>

#include "core/support/files.hpp"
#include "core/support/input_error.hpp"

namespace livermark::cli {

namespace {

std::vector<std::string> subcommand_names(const CLI::App &app) {
    std::vector<std::string> names;
    for (const auto *subcommand : app.get_subcommands({}))
        names.push_back(subcommand->get_name());
    return names;
}

std::vector<std::string> option_names(const CLI::App &app) {
    std::vector<std::string> names;
    for (const auto *option : app.get_options())
        for (const auto &name : option->get_lnames())
            names.push_back("--" + name);
    return names;
}

/// The subcommand that the words have come to.
const CLI::App &last_command(const CLI::App &app) {
    const auto parsed = app.get_subcommands();
    return parsed.empty() ? app : last_command(*parsed.back());
}

std::string full_name(const CLI::App &app) {
    return app.get_parent() ? fmt::format("{} {}", full_name(*app.get_parent()), app.get_name()) : app.get_name();
}

std::string about_unexpected(const std::string &word, const CLI::App &command) {
    if (!word.starts_with('-'))
        return fmt::format("'{}' is one word too many; leave it out, or see `{} --help`", word, full_name(command));
    const auto name = word.substr(0, word.find('='));
    const auto nearest = support::nearest_word(name, option_names(command));
    return fmt::format("`{}` has no option '{}'; {}", full_name(command), name,
                       nearest.empty() ? fmt::format("see `{} --help`", full_name(command))
                                       : fmt::format("did you mean '{}'?", nearest));
}

/// @param description  stands in --help
CLI::Validator number_where(bool (*is_good)(double), const char *wanted, const char *description) {
    return {[=](const std::string &text) {
                double value = 0.0;
                return CLI::detail::lexical_cast(text, value) && is_good(value)
                           ? std::string()
                           : fmt::format("'{}' has to be a finite number {}", text, wanted);
            },
            description, ""};
}

/// Help in which an option that is also an argument refers to the argument.
class ArgumentsOnce : public CLI::Formatter {
  public:
    std::string make_option(const CLI::Option *option, bool is_positional) const override {
        if (is_positional || !option->get_positional())
            return CLI::Formatter::make_option(option, is_positional);
        std::ostringstream text;
        CLI::detail::format_help(text, make_option_name(option, false) + make_option_opts(option),
                                 fmt::format("As the argument {}", option->get_name(true)), get_column_width());
        return text.str();
    }
};

using Regimes = std::vector<core::Regime>;

/// Words for a body in the help of every command.
constexpr auto *body_words =
    "a name as in 'livermark list bodies', or the path of a body .toml, a mesh, or a segmentation, which is meshed "
    "first: a label image (NIfTI, NRRD, MetaImage, DICOM), or closed surfaces (STL, OBJ, PLY, VTK, VTP), the liver and "
    "then each lesion";

/// Takes the values of "nodal_springs.a=0.1,0.25".
void read_sweep(const std::string &text, std::map<std::string, std::vector<double>> &sweeps) {
    const auto refuse = [&](const std::string &fault) {
        throw support::InputError(
            fmt::format("--sweep '{}': {}; write it as nodal_springs.a=0.1,0.15,0.25", support::shown(text), fault));
    };
    const auto end = std::min(text.find('='), text.size());
    const auto key = text.substr(0, end);
    const auto *const constant = std::ranges::find(models::swept_constants, key, &models::SweptConstant::key);
    if (constant == models::swept_constants.end()) {
        std::vector<std::string_view> known;
        for (const auto &each : models::swept_constants)
            known.push_back(each.key);
        refuse(fmt::format("the constants that can be swept are {}", fmt::join(known, ", ")));
    }
    std::vector<double> values;
    for (const auto &word : CLI::detail::split(text.substr(std::min(end + 1, text.size())), ',')) {
        double value = 0.0;
        if (!CLI::detail::lexical_cast(word, value) || !(value > 0.0 && value <= constant->largest))
            refuse(fmt::format("'{}' is not a number above 0 and at most {}", support::shown(word), constant->largest));
        values.push_back(value);
    }
    if (sorted_once(values).size() < values.size())
        refuse("a value is given twice");
    if (!sweeps.emplace(key, sorted_once(std::move(values))).second)
        refuse("the constant is given twice");
}

} // namespace

void describe_arguments_once(CLI::App &app) {
    app.formatter(std::make_shared<ArgumentsOnce>());
}

void refuse_empty_places(CLI::App &app) {
    for (const auto *const name : {"--output", "--picture", "--scan", "--data"})
        if (auto *option = app.get_option_no_throw(name))
            option->check(CLI::Validator(
                [](const std::string &place) {
                    return place.empty() ? std::string("the name is empty; give one, or leave the option out")
                                         : std::string();
                },
                ""));
    for (auto *subcommand : app.get_subcommands({}))
        refuse_empty_places(*subcommand);
}

void refuse_unknown_subcommand(const CLI::App &app, const std::vector<std::string> &words) {
    const auto known = subcommand_names(app);
    if (known.empty() || words.empty() || words.front().starts_with('-'))
        return;
    if (std::ranges::find(known, words.front()) == known.end())
        throw support::InputError(support::unknown_name("subcommand", words.front(), known));
    refuse_unknown_subcommand(*app.get_subcommand(words.front()), {words.begin() + 1, words.end()});
}

std::string usage_sentence(const CLI::App &app, const CLI::ParseError &error) {
    const auto &command = last_command(app);
    const auto unexpected = app.remaining(true);
    const auto is_option = [](const std::string &word) { return word.starts_with('-'); };
    // What is missing may be missing because of a slip here, so this comes first.
    if (const auto option = std::ranges::find_if(unexpected, is_option); option != unexpected.end())
        return about_unexpected(*option, command);
    if (dynamic_cast<const CLI::ValidationError *>(&error)) // checks say what would be right
        return error.what();
    if (const auto names = subcommand_names(command); !names.empty())
        return fmt::format("a subcommand is missing behind `{}`; give one of {}", full_name(command),
                           fmt::join(names, ", "));
    if (!unexpected.empty())
        return about_unexpected(unexpected.front(), command);
    return fmt::format("{}; see `{} --help`", error.what(), full_name(command));
}

CLI::Validator positive_number() {
    return number_where([](double value) { return value > 0.0 && std::isfinite(value); }, "above zero", "POSITIVE");
}

CLI::Validator number_not_below_zero() {
    return number_where([](double value) { return value >= 0.0 && std::isfinite(value); }, "of zero or more",
                        "NONNEGATIVE");
}

CLI::Validator one_of(const std::vector<std::string> &known) {
    return {[=](const std::string &text) {
                const auto word = CLI::detail::to_lower(text);
                return std::ranges::find(known, word) != known.end() ? std::string()
                                                                     : support::unknown_name("choice", text, known);
            },
            fmt::format("{{{}}}", fmt::join(known, ",")), ""};
}

CLI::Option *add_bodies(CLI::App &command, std::vector<std::string> &bodies, const std::string &which) {
    return command.add_option("body,--body", bodies, fmt::format("Bodies, each {}; {}", body_words, which));
}

CLI::Option *add_body(CLI::App &command, std::string &body) {
    return command.add_option("body,--body", body, fmt::format("The body: {}", body_words))->required();
}

void add_constraints(CLI::App &command, std::string &load_case) {
    command.add_option("--load-case", load_case,
                       "The load case that gives the constraints; by default traction, or if it does not fit the body, "
                       "the first shipped one that does");
}

namespace {

/// A folder for what is computed: in a source tree below its results/, else in those of the working directory.
std::string results_folder(const char *folder) {
    const auto root = support::root_folder();
    std::error_code ignored;
    const bool is_source_tree = std::filesystem::exists(root / "CMakeLists.txt", ignored);
    return ((is_source_tree ? root : std::filesystem::path()) / "results" / folder).string();
}

} // namespace

CLI::Option *add_output(CLI::App &command, std::string &output, const std::string &help, const char *folder) {
    output = results_folder(folder);
    return command.add_option("--output", output, help)->capture_default_str();
}

CLI::Option *add_data(CLI::App &command, std::string &data) {
    return command.add_option("--data", data,
                              "Folder with public data, before that of LIVERMARK_EXPERIMENTS and livermark/experiments "
                              "in your data directory");
}

void refuse_no_folder(const std::string &data) {
    std::error_code ignored;
    if (!data.empty() && !std::filesystem::is_directory(data, ignored))
        throw support::InputError("{}: this is no folder; give --data the one that the public data are in", data);
}

std::string runs_folder() {
    return results_folder("runs");
}

void add_materials(CLI::App &command, meshes::MaterialOverride &material) {
    command.add_option("--young", material.young_modulus,
                       "Young's modulus of the first region [Pa]; the others keep their ratio to it");
    command.add_option("--poisson", material.poisson_ratio, "Poisson's ratio of every region");
}

void add_reference_on_mesh(CLI::App &command, bool &reference_on_mesh) {
    command.add_flag("--reference-on-mesh", reference_on_mesh,
                     "Compare with the reference on the mesh itself, not on refined meshes: quicker, but its own error "
                     "stays unknown, and errors differ from those against the refined one");
    command
        .add_flag_function("--no-uncertainty",
                           [](std::int64_t) {
                               throw support::InputError("--no-uncertainty is now --reference-on-mesh, because errors "
                                                         "are then against another reference; write that");
                           })
        ->group(""); // not in the help
}

void add_run_choices(CLI::App &command, const std::shared_ptr<studies::RunOptions> &options) {
    command.add_option("--load-case", options->load_cases,
                       "Names as in 'livermark list load-cases', or paths of load case .toml files");
    command
        .add_option_function<std::string>(
            "--regime",
            [options](const std::string &word) {
                using enum core::Regime;
                const auto lower = CLI::detail::to_lower(word);
                options->has_asked_for_regime = true;
                options->regimes = lower == "all" ? Regimes{small, large} : Regimes{lower == "large" ? large : small};
            },
            "Load cases to run if none is named: small (reference: linear elasticity), large (deformations of surgical "
            "size; reference: hyperelasticity; minutes on each body) or all; named ones have to be of it")
        ->check(one_of(std::vector<std::string>{"small", "large", "all"}))
        ->default_str("small");
    command.add_option("--model", options->models,
                       "Names as in 'livermark list models'; the reference always runs too");
    command.add_option_function<std::vector<std::string>>(
        "--sweep",
        [options](const std::vector<std::string> &texts) {
            for (const auto &text : texts)
                read_sweep(text, options->model_options.sweeps);
        },
        "Additional values of a constant, such as nodal_springs.a=0.1,0.15,0.25; each value is another model, here "
        "nodal_springs_a_0_1 and so on. Other constants: nodal_neo_hookean.a and patch_nodal_volume.w");
    command
        .add_option("--poisson", options->poisson_ratios,
                    "Poisson's ratios of every region, such as 0.25,0.45,0.49; result files are then in a folder "
                    "poisson_<ratio> for each")
        ->delimiter(',');
    add_reference_on_mesh(command, options->reference_on_mesh);
    command
        .add_option("--jobs", options->jobs,
                    "Number of parallel workers, each on one core; by default one for each core, if memory allows. "
                    "With --jobs 1 no other worker disturbs the times of the models")
        ->check(CLI::Range(1, 1024));
}

std::vector<double> sorted_once(std::vector<double> values) {
    std::ranges::sort(values);
    values.erase(std::unique(values.begin(), values.end()), values.end());
    return values;
}

CLI::Validator a_regime() {
    return one_of(std::map<std::string, core::Regime>{{"small", core::Regime::small}, {"large", core::Regime::large}});
}

} // namespace livermark::cli
