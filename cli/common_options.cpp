#include "cli/common_options.hpp"

#include <algorithm>
#include <cstdint>
#include <fmt/ranges.h>
#include <map>
#include <string_view>

#include "cli/usage.hpp"
#include "support/input_error.hpp"

namespace livermark::cli {

namespace {

using Regimes = std::vector<core::Regime>;

/// What the help of every command says of a body.
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
