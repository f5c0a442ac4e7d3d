#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <memory>
#include <numeric>
#include <optional>
#include <stdexcept>

#include "app/catalogue.hpp"
#include "app/commands.hpp"
#include "app/msm_choice.hpp"
#include "app/patch_loads.hpp"
#include "app/progress.hpp"
#include "core/input_error.hpp"
#include "core/whole_file.hpp"
#include "fem_reference/mpi_session.hpp"
#include "meshes/body_reader.hpp"
#include "models/model_table.hpp"
#include "msm/calibration.hpp"
#include "msm/nodal_conditions.hpp"
#include "msm/springs_with_volume.hpp"
#include "results/calibration_file.hpp"
#include "results/provenance.hpp"
#include "results/table_layout.hpp"

namespace livermark::app {

namespace {

constexpr double percent = 100.0;
constexpr const char *volume_term = "nodal_volume";
constexpr double peak_displacement = 1e-3; ///< of each load; linear answers, so any other would do [m]
/// Every so many loads one has no part in the fit.
constexpr int held_out_stride = 4;
/// After so many iterations the state is written, and L-BFGS begins anew.
constexpr int round_length = 20;
/// A spring may become so many times softer or stiffer than it was.
constexpr double widest_change = 100.0;
/// A few loads do not tell tens of thousands of stiffnesses apart: what they leave open stays as it was. The weight is
/// the square of a ratio, of the error that is worth fitting to the change that is thought likely: 1 % (the reference
/// is no better) to 30 % or so. On the healthy liver after 100 iterations, weights of 1e-2, 1e-3 and 1e-4 leave
/// held-out errors of 2.36, 2.10 and 2.03 %; below 1e-3 the softest springs still get softer, for next to nothing.
constexpr double default_penalty = 1e-3;

struct CalibrateOptions {
    std::string body;
    std::string law = "patch";
    std::string held = "posterior";
    int num_loads = 24;
    std::int64_t seed = 1;
    int num_iterations = 100;
    double penalty = default_penalty;
    meshes::MaterialOverride material;
    std::string output;
    bool restart = false;
    bool markdown = false;
};

std::filesystem::path output_file(const CalibrateOptions &options, const std::filesystem::path &body_file) {
    if (!options.output.empty())
        return options.output;
    return body_file.parent_path() / (body_file.stem().string() + ".calibrated.h5");
}

results::Calibration begin(const CalibrateOptions &options, const core::Body &body) {
    auto springs = msm::springs_beside_volume(body, find_spring_law(options.law));
    results::Calibration calibration;
    calibration.body = body.name;
    calibration.spring_law = options.law;
    calibration.volume_term = volume_term;
    calibration.reference = models::references.front().on_mesh;
    calibration.held = options.held;
    calibration.seed = options.seed;
    calibration.penalty = options.penalty;
    calibration.start_stiffness = springs.stiffness;
    calibration.springs = {.origin = {},
                           .materials = body.materials,
                           .edges = std::move(springs.edges),
                           .rest_length = std::move(springs.rest_length),
                           .stiffness = std::move(springs.stiffness)};
    for (int l = 0; l < options.num_loads; ++l)
        calibration.held_out.push_back(l % held_out_stride == held_out_stride - 1 ? 1 : 0);
    return calibration;
}

/// Goes on where an earlier call stopped, if that was the same calibration.
results::Calibration resume(const std::filesystem::path &file, const results::Calibration &fresh,
                            const core::Body &body) {
    auto earlier = results::read_calibration(file);
    core::check_fit(earlier.springs, body);
    const auto same = [](const results::Calibration &a, const results::Calibration &b) {
        return a.spring_law == b.spring_law && a.volume_term == b.volume_term && a.reference == b.reference &&
               a.held == b.held && a.seed == b.seed && a.penalty == b.penalty && a.held_out == b.held_out &&
               a.start_stiffness == b.start_stiffness;
    };
    if (!same(earlier, fresh))
        throw core::InputError(fmt::format("{}: was begun with another law, patch, seed, penalty or number of loads; "
                                           "give those again, or --restart, or another --output",
                                           file.string()));
    return earlier;
}

/// What finite elements answer to each load, both scaled to the same peak.
std::vector<msm::WantedAnswer> answers_of_reference(const std::shared_ptr<const core::Body> &body,
                                                    const std::vector<core::LoadCase> &loads,
                                                    const results::Calibration &calibration,
                                                    const std::vector<double> &node_mass) {
    const auto models = models::all_models();
    const auto &reference = *std::ranges::find(models, calibration.reference, &core::Model::name);
    std::vector<msm::WantedAnswer> answers;
    Progress progress(static_cast<int>(loads.size()));
    for (const auto &load : loads) {
        progress.next(fmt::format("{} / {}", load.name, reference.name));
        const core::Problem problem{body, load};
        auto solution = reference.solve(problem);
        double peak = 0.0;
        for (const auto &displacement : solution.displacement)
            peak = std::max(peak, displacement.norm());
        if (solution.status != core::SolutionStatus::ok || !(peak > 0.0))
            throw std::runtime_error(fmt::format("{} ends with status {} on {}: {}", reference.name,
                                                 core::to_string(solution.status), load.name, solution.message));
        answers.push_back({msm::nodal_conditions(problem, node_mass).force, std::move(solution.displacement)});
        for (auto *field : {&answers.back().force, &answers.back().displacement})
            for (auto &value : *field)
                value *= peak_displacement / peak;
    }
    return answers;
}

msm::CalibrationTask make_task(const std::shared_ptr<const core::Body> &body, const CalibrateOptions &options,
                               const results::Calibration &calibration) {
    const auto &points = body->mesh.points;
    const auto loads = random_patch_loads(body->mesh, options.held, options.num_loads, options.seed);
    msm::CalibrationTask task;
    task.points = points;
    task.springs = msm::springs_beside_volume(*body, find_spring_law(options.law));
    task.other_stiffness = msm::volume_beside_springs(*body, msm::find_volume_term(volume_term))
                               ->hessian(msm::to_unknowns(points), msm::Tangent::material);
    task.held = msm::nodal_conditions({body, loads.front()}, task.springs.node_mass).displacement;
    task.nodal_volume = core::nodal_volumes(body->mesh);
    task.penalty = options.penalty;
    auto answers = answers_of_reference(body, loads, calibration, task.springs.node_mass);
    for (std::size_t l = 0; l < answers.size(); ++l)
        (calibration.held_out[l] != 0 ? task.held_out : task.training).push_back(std::move(answers[l]));
    return task;
}

/// The errors of all loads in their order.
std::vector<double> in_order(const msm::CalibrationState &state, const std::vector<std::uint8_t> &held_out) {
    std::vector<double> errors;
    auto training = state.training_errors.begin();
    auto other = state.held_out_errors.begin();
    for (const bool is_held_out : held_out)
        errors.push_back(is_held_out ? *other++ : *training++);
    return errors;
}

double mean(const std::vector<double> &values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

msm::CalibrationState evaluate(msm::CalibrationObjective &objective, const std::vector<double> &stiffness) {
    auto state = objective.evaluate(
        Eigen::VectorXd::Map(stiffness.data(), static_cast<Eigen::Index>(stiffness.size())).array().log());
    if (!std::isfinite(state.objective))
        throw core::InputError("the body is not stiff in every direction; hold it at more facets, or take a Poisson's "
                               "ratio of 1/4 or more");
    return state;
}

void improve(results::Calibration &calibration, msm::CalibrationObjective &objective, const CalibrateOptions &options,
             const std::filesystem::path &file, const std::string &command_line) {
    if (calibration.iterations == 0)
        calibration.error_before = in_order(evaluate(objective, calibration.start_stiffness), calibration.held_out);
    const auto num_rounds = (options.num_iterations - static_cast<int>(calibration.iterations)) / round_length;
    Progress progress(num_rounds * round_length);
    for (int round = 0; round < num_rounds; ++round) {
        auto &stiffness = calibration.springs.stiffness;
        stiffness = msm::calibration_round(
            objective, stiffness, round_length, widest_change, [&](const msm::CalibrationState &state) {
                progress.next(fmt::format("objective {:.6f}, mean error {:.2f} % in training, {:.2f} % held out",
                                          state.objective, percent * mean(state.training_errors),
                                          percent * mean(state.held_out_errors)));
            });
        calibration.iterations += round_length;
        calibration.error_after = in_order(evaluate(objective, stiffness), calibration.held_out);
        calibration.provenance = results::current_provenance(command_line);
        results::write_calibration(file, calibration);
    }
}

void print_errors(const results::Calibration &calibration, bool markdown) {
    results::Layout table{{{"loads", false},
                           {"number", true},
                           {"mean before [%]", true},
                           {"worst before [%]", true},
                           {"mean after [%]", true},
                           {"worst after [%]", true}},
                          {}};
    for (const bool held_out : {false, true}) {
        std::vector<double> before, after;
        for (std::size_t l = 0; l < calibration.held_out.size(); ++l)
            if ((calibration.held_out[l] != 0) == held_out) {
                before.push_back(calibration.error_before[l]);
                after.push_back(calibration.error_after[l]);
            }
        const auto in_percent = [](double error) { return results::fixed(percent * error, 2); };
        table.rows.push_back({held_out ? "held out" : "training", fmt::format("{}", before.size()),
                              in_percent(mean(before)), in_percent(*std::ranges::max_element(before)),
                              in_percent(mean(after)), in_percent(*std::ranges::max_element(after))});
    }
    fmt::print("{}: relative L2 errors to {} after {} iterations from {}\n{}{}", calibration.body,
               calibration.reference, calibration.iterations, calibration.spring_law, markdown ? "\n" : "",
               markdown ? results::to_markdown(table) : results::to_text(table));
}

int calibrate(const CalibrateOptions &options, const std::string &command_line) {
    if (fem_reference::mpi_num_ranks() > 1)
        throw core::InputError("`livermark calibrate` works on one rank only; start it without mpirun");
    const auto body_file = find_toml_files({options.body}, bodies_folder, "body").front();
    const auto body = std::make_shared<const core::Body>(meshes::read_body(body_file, options.material));
    const auto file = output_file(options, body_file);
    core::check_place(file);
    auto calibration = begin(options, *body);
    if (!options.restart && std::filesystem::exists(file))
        calibration = resume(file, calibration, *body);
    if (calibration.iterations < options.num_iterations) {
        msm::CalibrationObjective objective(make_task(body, options, calibration));
        improve(calibration, objective, options, file, command_line);
    }
    print_errors(calibration, options.markdown);
    fmt::print(stderr, "The calibration is in {}\n", file.string());
    return 0;
}

} // namespace

Command add_calibrate(CLI::App &parent, const std::string &command_line) {
    auto *command = parent.add_subcommand(
        "calibrate", "Fit the stiffness of every spring of a body to finite element answers under random loads");
    auto options = std::make_shared<CalibrateOptions>();
    command->add_option("body", options->body, "A name as in 'livermark list bodies', or the path of a body .toml file")
        ->required();
    command->add_option("--law", options->law, "The spring law to start from")->capture_default_str();
    command->add_option("--held", options->held, "The patch where the body is held")->capture_default_str();
    command->add_option("--loads", options->num_loads, "How many loads; every fourth has no part in the fit")
        ->check(CLI::Range(held_out_stride, 1000))
        ->capture_default_str();
    command->add_option("--seed", options->seed, "Of the random loads")
        ->check(CLI::NonNegativeNumber)
        ->capture_default_str();
    command
        ->add_option("--iterations", options->num_iterations,
                     "How often to evaluate the objective in all, those of earlier calls included; in rounds of 20")
        ->check([](const std::string &text) {
            int value = 0;
            return CLI::detail::lexical_cast(text, value) && value >= round_length && value % round_length == 0
                       ? ""
                       : fmt::format("takes a multiple of {}", round_length);
        })
        ->capture_default_str();
    command
        ->add_option("--penalty", options->penalty,
                     "Weight of the mean square of ln(k / start) beside the mean square relative error")
        ->check(CLI::Range(0.0, 1e6))
        ->capture_default_str();
    command->add_option("--young", options->material.young_modulus,
                        "Young's modulus of the first region [Pa]; the others keep their ratio to it");
    command->add_option("--poisson", options->material.poisson_ratio, "Poisson's ratio of every region");
    command->add_option("--output", options->output,
                        "The file to write, and to go on from; <body>.calibrated.h5 beside the body's .toml if it is "
                        "not given");
    command->add_flag("--restart", options->restart, "Begin anew even if the file is there");
    command->add_flag("--markdown", options->markdown, "Print the table in Markdown");
    return [options, command_line] { return calibrate(*options, command_line); };
}

} // namespace livermark::app
