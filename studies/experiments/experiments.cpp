#include "studies/experiments/experiments.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/ranges.h>
#include <functional>
#include <iterator>
#include <limits>
#include <memory>
#include <numeric>
#include <utility>

#include "core/mesh/plausible_liver.hpp"
#include "core/mesh/refinement.hpp"
#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "load_cases/experiments/experiment.hpp"
#include "load_cases/experiments/markers.hpp"
#include "meshes/generators/box_generator.hpp"
#include "results/records/experiment.hpp"
#include "results/records/result.hpp"
#include "studies/models/model_table.hpp"
#include "studies/models/motion/moving_method.hpp"
#include "studies/study.hpp"

namespace livermark::studies {

namespace {

using core::Vector3;

/// The states of an experiment on one mesh.
struct StatesOnMesh {
    std::shared_ptr<const core::Body> body;
    std::vector<core::LoadCase> load_cases; ///< (S)
    experiments::MarkerField field;
};

StatesOnMesh states_on_mesh(const experiments::Experiment &experiment, core::Body made,
                            const std::vector<Vector3> &positions) {
    const auto body = std::make_shared<const core::Body>(std::move(made));
    StatesOnMesh states{body, {}, experiments::MarkerField(body->mesh, positions)};
    for (const auto &state : experiment.states)
        states.load_cases.push_back(experiments::problem_of(experiment, state, body).load_case);
    return states;
}

StatesOnMesh refined(const StatesOnMesh &coarse, const std::vector<Vector3> &positions) {
    const auto body = std::make_shared<const core::Body>(core::refine(*coarse.body));
    StatesOnMesh states{body, {}, experiments::MarkerField(body->mesh, positions)};
    for (const auto &load_case : coarse.load_cases)
        states.load_cases.push_back(core::refine(load_case, coarse.body->mesh));
    return states;
}

/// A sentence for each number that may be in another unit, and for markers far off the body, each once.
std::vector<std::string> doubts_about(const experiments::Experiment &experiment, const StatesOnMesh &states) {
    const auto &mesh = states.body->mesh;
    auto doubts = core::doubts_about_materials(states.body->materials, mesh.region_names);
    const auto add = [&](const std::vector<std::string> &more) {
        for (const auto &doubt : more)
            if (std::ranges::find(doubts, doubt) == doubts.end())
                doubts.push_back(doubt);
    };
    for (const auto &load_case : states.load_cases)
        add(core::doubts_about_loads(load_case, mesh));
    add(experiments::doubts_about_markers(experiment.markers, mesh, states.field.outside()));
    for (const auto &state : experiment.states) {
        double largest = 0.0;
        for (const auto &displacement : state.displacement)
            if (displacement.allFinite())
                largest = std::max(largest, displacement.norm());
        add(core::doubts_about_noise(state.noise, largest));
    }
    return doubts;
}

/// The name of the reference on the mesh itself, for the regime of the states.
std::string reference_of(const StatesOnMesh &states) {
    const auto regime = states.load_cases.front().regime;
    for (const auto &load_case : states.load_cases)
        if (load_case.regime != regime)
            throw support::InputError(fmt::format("state {} is of another regime than state {}; make two experiments",
                                                  load_case.name, states.load_cases.front().name));
    return models::static_reference(regime).on_mesh;
}

std::vector<core::Model> chosen_models(const ExperimentOptions &options, const StatesOnMesh &states,
                                       const std::string &reference) {
    auto known = models::all_models();
    const auto methods = support::names_of(models::all_moving_methods());
    const auto is_method = [&](const core::Model &model) {
        return model.only_when_named && std::ranges::find(methods, model.name) != methods.end();
    };
    for (const auto &name : options.models)
        support::find_named(known, name, "model");
    std::erase_if(known, [&](const core::Model &model) {
        if (model.name == reference)
            return false;
        const bool takes_part = std::ranges::all_of(states.load_cases, [&](const core::LoadCase &load_case) {
            return model.takes_part_in({states.body, load_case}) && !model.only_moving;
        });
        if (!options.models.empty())
            return std::ranges::find(options.models, model.name) == options.models.end() || !takes_part;
        const bool refines_itself = model.at_rest == core::Role::refined_reference;
        const bool is_left_out = model.only_when_named && !(options.with_methods && is_method(model));
        return !takes_part || refines_itself || is_left_out;
    });
    for (const auto &name : options.models)
        if (std::ranges::find(known, name, &core::Model::name) == known.end())
            throw support::InputError(fmt::format("model {} takes no part in deformations of the {} regime, or not in "
                                                  "these conditions; leave it out",
                                                  name, core::to_string(states.load_cases.front().regime)));
    return known;
}

results::ExperimentResult without_runs(const experiments::Experiment &experiment, const StatesOnMesh &states,
                                       const std::vector<Vector3> &positions, const std::string &command_line) {
    results::ExperimentResult result{.provenance = results::current_provenance(command_line),
                                     .name = experiment.name,
                                     .title = experiment.title,
                                     .source = experiment.source,
                                     .assumptions = experiment.assumptions,
                                     .reference = reference_of(states),
                                     .markers = {},
                                     .drives = {},
                                     .positions = positions,
                                     .states = {},
                                     .runs = {},
                                     .points = states.body->mesh.points,
                                     .boundary = states.body->mesh.boundary_triangles};
    std::ranges::copy(states.body->assumptions, std::back_inserter(result.assumptions));
    for (const auto &marker : experiment.markers) {
        result.markers.push_back(marker.name);
        result.drives.push_back(marker.drives);
    }
    return result;
}

/// A state without a model.
results::ExperimentState without_models(const experiments::Experiment &experiment,
                                        const experiments::MeasuredState &measured,
                                        const results::ExperimentResult &result) {
    results::ExperimentState state{
        .name = measured.name, .displacement = measured.displacement, .noise = measured.noise};
    const auto error = [&](const std::vector<Vector3> &displacement) {
        return results::marker_error(result, displacement, measured.displacement).root_mean_square;
    };
    const auto num_markers = result.markers.size();
    state.no_motion = error(std::vector<Vector3>(num_markers, Vector3::Zero()));
    std::vector<Vector3> points, targets, rigid;
    for (std::size_t k = 0; k < num_markers; ++k)
        if (result.is_compared(k) && measured.displacement[k].allFinite()) {
            points.push_back(result.positions[k]);
            targets.emplace_back(result.positions[k] + measured.displacement[k]);
        }
    state.rigid_motion = results::not_known;
    if (points.size() >= experiments::fewest_of_rigid_motion) {
        const auto fitted = experiments::best_rigid_motion(points, targets);
        for (const auto &position : result.positions)
            rigid.emplace_back(fitted.at(position) - position);
        state.rigid_motion = error(rigid);
    }
    if (const auto fitted = experiments::best_affine_motion(points, targets)) {
        std::vector<Vector3> affine;
        for (const auto &position : result.positions)
            affine.emplace_back(fitted->at(position) - position);
        state.affine_map = error(affine);
    }
    const auto places = experiments::driven_places(experiment, measured);
    for (const auto &place : places)
        state.fit_residual += place.motion.residual() * place.motion.residual() / static_cast<double>(places.size());
    state.fit_residual = std::sqrt(state.fit_residual);
    if (places.size() == 2) {
        std::vector<Vector3> line;
        for (const auto &position : result.positions)
            line.push_back(experiments::straight_line(places[0], places[1], position));
        state.straight_line = error(line);
    }
    return state;
}

void add_runs(results::ExperimentResult &result, const std::string &model, const StatesOnMesh &on_mesh,
              const std::vector<core::Solution> &solutions) {
    for (std::size_t s = 0; s < solutions.size(); ++s) {
        const auto &solution = solutions[s];
        results::ExperimentRun run{.model = model,
                                   .state = static_cast<int>(s),
                                   .tetrahedra = on_mesh.body->mesh.num_tetrahedra(),
                                   .status = solution.status,
                                   .message = solution.message,
                                   .seconds = solution.setup_seconds + solution.solve_seconds,
                                   .displacement = on_mesh.field.at_points(solution.displacement)};
        const auto error = results::marker_error(result, run.displacement, result.states[s].displacement);
        run.error = error.root_mean_square;
        run.worst_error = error.worst;
        run.component_error = error.component;
        result.runs.push_back(std::move(run));
    }
}

std::vector<core::Solution> solve_all(const core::Model &model, const StatesOnMesh &states) {
    for (const auto &load_case : states.load_cases)
        if (model.check)
            model.check({states.body, load_case});
    return model.prepare(states.body, nullptr)->solve(states.load_cases);
}

/// A state whose force was measured, without a model.
results::ForceResult without_models(const experiments::MeasuredState &measured, const core::LoadCase &load_case,
                                    const core::Body &body) {
    const auto &force = *measured.force;
    results::ForceResult result{.state = measured.name,
                                .place = force.place,
                                .way = force.way,
                                .force = force.force,
                                .deviation = force.deviation,
                                .young_modulus = body.materials.front().young_modulus,
                                .uniform = experiments::uniform_force(force, load_case, body.mesh),
                                .runs = {}};
    for (auto &uniform : result.uniform)
        uniform *= result.young_modulus;
    return result;
}

void add_forces(results::ExperimentResult &result, const experiments::Experiment &experiment, const std::string &model,
                const StatesOnMesh &on_mesh, const std::vector<core::Solution> &solutions) {
    double seconds = 0.0;
    for (const auto &solution : solutions)
        seconds += solution.setup_seconds + solution.solve_seconds;
    for (auto &measured : result.forces) {
        const auto state = std::ranges::find(experiment.states, measured.state, &experiments::MeasuredState::name);
        const auto s = static_cast<std::size_t>(state - experiment.states.begin());
        measured.runs.push_back(
            {.model = model,
             .tetrahedra = on_mesh.body->mesh.num_tetrahedra(),
             .status = solutions[s].status,
             .message = solutions[s].message,
             .force = experiments::force_along_way(*state->force, on_mesh.load_cases[s], solutions[s]),
             .seconds = seconds});
    }
}

/// The reference on the refined mesh: how far it is from that on the mesh, and the shape of the body.
void add_refined_reference(results::ExperimentResult &result, const experiments::Experiment &experiment,
                           const core::Model &model, const StatesOnMesh &fine,
                           const std::vector<core::Solution> &coarse) {
    const auto solutions = solve_all(model, fine);
    add_forces(result, experiment, model.name, fine, solutions);
    const auto first_coarse = std::ranges::find(result.runs, model.name, &results::ExperimentRun::model);
    const auto first = first_coarse - result.runs.begin();
    add_runs(result, model.name, fine, solutions);
    for (std::size_t s = 0; s < solutions.size(); ++s) {
        const auto &last = result.runs[result.runs.size() - solutions.size() + s];
        const auto &before = result.runs[first + s];
        auto &state = result.states[s];
        const bool is_solved =
            solutions[s].status == core::SolutionStatus::ok && coarse[s].status == core::SolutionStatus::ok;
        if (is_solved)
            state.reference_uncertainty =
                results::marker_error(result, last.displacement, before.displacement).root_mean_square;
        const auto &shape = is_solved && !experiment.finer_body ? solutions[s].displacement : coarse[s].displacement;
        state.deformed.assign(shape.begin(), shape.begin() + std::ssize(result.points)); // nodes of the mesh are first
    }
}

/// Ring-downs of all models that move, the reference of motion among them: that also with edges twice as long, which
/// tells how far the mesh matters.
void add_ring_downs(results::ExperimentResult &result, const experiments::Experiment &experiment, double edge_length,
                    const ExperimentOptions &options, const std::vector<core::Model> &chosen, core::Regime regime,
                    const std::function<void(const std::string &)> &begin) {
    std::vector<int> markers(result.markers.size());
    std::iota(markers.begin(), markers.end(), 0);
    result.damping_from = experiment.damping_from;
    std::vector<double> frequencies;
    for (const auto &ring_down : experiment.ring_downs) {
        result.ring_downs.push_back(measured_ring_down(ring_down, result.positions, markers));
        frequencies.push_back(result.ring_downs.back().frequency);
    }
    const auto &from = *std::ranges::find(result.ring_downs, result.damping_from, &results::RingDownResult::state);
    const auto [lowest, highest] = std::ranges::minmax_element(frequencies);
    const auto damping = fitted_damping(options.damping, from.damping_ratio, from.frequency, *lowest, *highest);
    const auto moving = models::moving_reference(regime).on_mesh;
    const auto run = [&](const core::Model &model, double edge) {
        for (std::size_t n = 0; n < experiment.ring_downs.size(); ++n)
            for (auto &found : ring_down_of_model(model, experiment.ring_downs[n], result.ring_downs[n], edge, damping,
                                                  from.frequency, result.positions, markers))
                result.ring_downs[n].runs.push_back(std::move(found));
    };
    for (const auto &model : chosen)
        if (model.name != moving) {
            begin(model.name);
            run(model, edge_length);
        }
    const auto all = models::all_models();
    const auto &reference = support::find_named(all, std::string(moving), "model");
    begin(reference.name);
    run(reference, edge_length);
    if (experiment.edge_length > 0.0 && options.refines_reference)
        run(reference, 2.0 * edge_length);
}

/// Root mean square error of the markers over all states, of a model with another material.
double error_with(const core::Material &material, const core::Model &model, const StatesOnMesh &states,
                  const results::ExperimentResult &result) {
    auto body = *states.body;
    body.materials.assign(body.materials.size(), material);
    double squares = 0.0;
    const auto solutions =
        model.prepare(std::make_shared<const core::Body>(std::move(body)), nullptr)->solve(states.load_cases);
    for (std::size_t s = 0; s < solutions.size(); ++s) {
        if (solutions[s].status != core::SolutionStatus::ok)
            return std::numeric_limits<double>::infinity();
        const auto error = results::marker_error(result, states.field.at_points(solutions[s].displacement),
                                                 result.states[s].displacement);
        squares += error.root_mean_square * error.root_mean_square / static_cast<double>(solutions.size());
    }
    return std::sqrt(squares);
}

/// Whether anything but prescribed displacements drives the body.
bool has_loads(const StatesOnMesh &states) {
    return std::ranges::any_of(states.load_cases, [](const core::LoadCase &load_case) {
        return !load_case.acceleration.isZero(0.0) ||
               std::ranges::any_of(load_case.conditions, &core::Condition::is_traction);
    });
}

} // namespace

results::ExperimentResult evaluate_experiment(const experiments::Experiment &experiment,
                                              const ExperimentOptions &options, const std::string &command_line,
                                              const ProgressReport &report) {
    if (options.edge_length && experiment.edge_length == 0.0)
        throw support::InputError(fmt::format("the body of {} has a mesh of its own; leave --edge-length out, or give "
                                              "a box or a cylinder",
                                              experiment.name));
    std::vector<Vector3> positions;
    for (const auto &marker : experiment.markers)
        positions.push_back(marker.position);
    if (options.edge_length && experiment.expected_tetrahedra && report)
        report(1, 1,
               fmt::format("{}: a mesh of {}", experiment.name,
                           meshes::text_of_expected_tetrahedra(experiment.expected_tetrahedra(*options.edge_length))));
    const double edge_length = options.edge_length.value_or(experiment.edge_length);
    const auto states = states_on_mesh(experiment, experiment.body(edge_length), positions);
    const auto reference = reference_of(states);
    const auto chosen = chosen_models(options, states, reference);
    auto result = without_runs(experiment, states, positions, command_line);
    std::ranges::move(doubts_about(experiment, states), std::back_inserter(result.assumptions));
    for (std::size_t s = 0; s < experiment.states.size(); ++s) {
        const auto &measured = experiment.states[s];
        result.states.push_back(without_models(experiment, measured, result));
        if (measured.force)
            result.forces.push_back(without_models(measured, states.load_cases[s], *states.body));
    }
    const bool rings_down = options.rings_down && !experiment.ring_downs.empty();
    const bool fits = options.fits_materials && result.has_compared_markers();
    if (fits && states.body->materials.size() != 1)
        throw support::InputError(fmt::format("{} has {} materials, and --fit fits one; leave --fit out",
                                              experiment.name, states.body->materials.size()));
    const auto num_rounds = 1 + (rings_down ? 1 : 0) + (fits ? 1 : 0);
    Steps steps(num_rounds * (static_cast<int>(chosen.size()) + 1), report);
    std::vector<core::Solution> reference_solutions;
    for (const auto &model : chosen) {
        steps.next(fmt::format("{}: {}", experiment.name, model.name));
        auto solutions = solve_all(model, states);
        add_runs(result, model.name, states, solutions);
        add_forces(result, experiment, model.name, states, solutions);
        if (model.name == reference)
            reference_solutions = std::move(solutions);
    }
    for (std::size_t s = 0; s < reference_solutions.size(); ++s)
        result.states[s].deformed = reference_solutions[s].displacement;
    if (options.refines_reference) {
        steps.next(fmt::format("{}: {} on {}", experiment.name, reference,
                               experiment.finer_body ? "a finer mesh" : "a mesh with each tetrahedron cut into eight"));
        add_refined_reference(result, experiment, support::find_named(chosen, reference, "model"),
                              experiment.finer_body
                                  ? states_on_mesh(experiment, experiment.finer_body(edge_length), positions)
                                  : refined(states, positions),
                              reference_solutions);
    }
    results::compare_with_reference(result);
    if (fits)
        for (const auto &model : chosen) {
            steps.next(fmt::format("{}: the material of {}", experiment.name, model.name));
            result.fits.push_back(fit_material(
                model.name, states.body->materials.front(), has_loads(states),
                [&](const core::Material &material) { return error_with(material, model, states, result); }));
        }
    if (rings_down)
        add_ring_downs(
            result, experiment, edge_length, options, chosen, states.load_cases.front().regime,
            [&](const std::string &model) { steps.next(fmt::format("{}: {} is let go", experiment.name, model)); });
    return result;
}

ExperimentResults run_experiments(const ExperimentOptions &options, const std::string &command_line,
                                  const ProgressReport &report) {
    ExperimentResults found;
    std::vector<experiments::Experiment> read;
    const auto num_names = static_cast<int>(options.names.size());
    const auto say = [&](const std::string &about) {
        if (report)
            report(static_cast<int>(read.size()) + 1, num_names, about);
    };
    for (const auto &name : options.names)
        read.push_back(
            support::file_ending(name) == ".toml"
                ? experiments::read_experiment(name, say)
                : experiments::read_public(support::find_named(experiments::all_public_data(), name, "experiment"),
                                           options.data));
    if (options.names.empty())
        for (const auto &experiment : experiments::all_public_data()) {
            if (experiments::public_data(experiment.data, options.data))
                read.push_back(experiments::read_public(experiment, options.data));
            else
                found.notes.push_back(experiments::where_to_get(experiment));
        }
    if (read.empty())
        throw support::InputError(
            fmt::format("{}; or give the .toml of an experiment of your own", fmt::join(found.notes, "; ")));
    for (const auto &experiment : read) {
        const OutputFile file(options.output, experiment.name + ".h5");
        found.records.push_back(evaluate_experiment(experiment, options, command_line, report));
        results::write_experiment(file.path(), found.records.back());
        found.files.push_back(file.path().string());
    }
    return found;
}

} // namespace livermark::studies
