#include "studies/calibration/calibrate.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <memory>
#include <numeric>
#include <stdexcept>

#include "core/units.hpp"
#include "models/model_table.hpp"
#include "msm/calibration.hpp"
#include "msm/nodal_conditions.hpp"
#include "msm/springs/springs_with_volume.hpp"
#include "results/provenance.hpp"
#include "studies/calibration/patch_loads.hpp"
#include "studies/catalogue.hpp"
#include "studies/msm_choice.hpp"
#include "studies/run/prepared_models.hpp"
#include "support/input_error.hpp"
#include "support/processes/mpi_session.hpp"
#include "support/whole_file.hpp"

namespace livermark::studies {

namespace {

using core::percent;
constexpr const char *volume_term = "nodal_volume";
constexpr double peak_displacement = 1e-3; ///< of each load; linear solutions, so any other would do [m]
/// A spring may become so many times softer or stiffer than it was.
constexpr double widest_change = 100.0;

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
    calibration.reference = models::static_reference(core::Regime::small).on_mesh;
    calibration.constrained = options.constrained;
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
               a.constrained == b.constrained && a.seed == b.seed && a.penalty == b.penalty &&
               a.held_out == b.held_out && a.start_stiffness == b.start_stiffness;
    };
    if (!same(earlier, fresh))
        throw support::InputError(
            fmt::format("{}: was begun with another law, patch, seed, penalty or number of loads; "
                        "give those again, or --restart, or another --output",
                        file.string()));
    return earlier;
}

/// The solution of finite elements for each load, both scaled to the same peak.
std::vector<msm::ExpectedSolution> reference_solutions(const std::shared_ptr<const core::Body> &body,
                                                       const std::vector<core::LoadCase> &loads,
                                                       const results::Calibration &calibration,
                                                       const std::vector<double> &node_mass,
                                                       const ProgressReport &report) {
    const auto models = models::all_models();
    const auto &reference = *std::ranges::find(models, calibration.reference, &core::Model::name);
    PreparedModels prepared;
    std::vector<msm::ExpectedSolution> solutions;
    Steps steps(static_cast<int>(loads.size()), report);
    for (const auto &load : loads) {
        steps.next(fmt::format("{} / {}", load.name, reference.name));
        const core::Problem problem{body, load};
        auto solution = prepared.solve(reference, problem);
        double peak = 0.0;
        for (const auto &displacement : solution.displacement)
            peak = std::max(peak, displacement.norm());
        if (solution.status != core::SolutionStatus::ok || !(peak > 0.0))
            throw std::runtime_error(fmt::format("{} ends with status {} on {}: {}", reference.name,
                                                 core::to_string(solution.status), load.name, solution.message));
        solutions.push_back({msm::nodal_conditions(problem, node_mass).force, std::move(solution.displacement)});
        for (auto *field : {&solutions.back().force, &solutions.back().displacement})
            for (auto &value : *field)
                value *= peak_displacement / peak;
    }
    return solutions;
}

msm::CalibrationTask make_task(const std::shared_ptr<const core::Body> &body, const CalibrateOptions &options,
                               const results::Calibration &calibration, const ProgressReport &report) {
    const auto &points = body->mesh.points;
    const auto loads = random_patch_loads(body->mesh, options.constrained, options.num_loads, options.seed);
    msm::CalibrationTask task;
    task.points = points;
    task.springs = msm::springs_beside_volume(*body, find_spring_law(options.law));
    task.other_stiffness = msm::volume_beside_springs(*body, msm::find_volume_term(volume_term))
                               ->hessian(msm::to_unknowns(points), msm::Tangent::material);
    task.constrained = msm::nodal_conditions({body, loads.front()}, task.springs.node_mass).displacement;
    task.nodal_volume = core::nodal_volumes(body->mesh);
    task.penalty = options.penalty;
    auto solutions = reference_solutions(body, loads, calibration, task.springs.node_mass, report);
    for (std::size_t l = 0; l < solutions.size(); ++l)
        (calibration.held_out[l] != 0 ? task.held_out : task.training).push_back(std::move(solutions[l]));
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
        throw support::InputError(
            "the body is not stiff in every direction; constrain more facets, or take a Poisson's "
            "ratio of 1/4 or more");
    return state;
}

void improve(results::Calibration &calibration, msm::CalibrationObjective &objective, const CalibrateOptions &options,
             const std::filesystem::path &file, const std::string &command_line, const ProgressReport &report) {
    if (calibration.iterations == 0)
        calibration.error_before = in_order(evaluate(objective, calibration.start_stiffness), calibration.held_out);
    const auto num_rounds = (options.num_iterations - static_cast<int>(calibration.iterations)) / round_length;
    Steps steps(num_rounds * round_length, report);
    for (int round = 0; round < num_rounds; ++round) {
        auto &stiffness = calibration.springs.stiffness;
        stiffness = msm::calibration_round(
            objective, stiffness, round_length, widest_change, [&](const msm::CalibrationState &state) {
                steps.next(fmt::format("objective {:.6f}, mean error {:.2f} % in training, {:.2f} % held out",
                                       state.objective, percent * mean(state.training_errors),
                                       percent * mean(state.held_out_errors)));
            });
        calibration.iterations += round_length;
        calibration.error_after = in_order(evaluate(objective, stiffness), calibration.held_out);
        calibration.provenance = results::current_provenance(command_line);
        results::write_calibration(file, calibration);
    }
}

} // namespace

CalibrationResult calibrate(const CalibrateOptions &options, const std::string &command_line,
                            const ProgressReport &report) {
    if (support::mpi_num_ranks() > 1)
        throw support::InputError("`livermark calibrate` works on one rank only; start it without mpirun");
    const auto body_file = find_toml_files({options.body}, bodies_folder, "body").front();
    const auto body = std::make_shared<const core::Body>(meshes::read_body(body_file, options.material));
    const auto file = output_file(options, body_file);
    support::check_place(file);
    auto calibration = begin(options, *body);
    if (!options.restart && std::filesystem::exists(file))
        calibration = resume(file, calibration, *body);
    if (calibration.iterations < options.num_iterations) {
        msm::CalibrationObjective objective(make_task(body, options, calibration, report));
        improve(calibration, objective, options, file, command_line, report);
    }
    return {std::move(calibration), file};
}

} // namespace livermark::studies
