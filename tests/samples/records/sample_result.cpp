#include "tests/samples/records/sample_result.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <string>

#include "core/tool/tool_stiffness.hpp"
#include "tests/samples/even_foundation.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::tests {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

core::Problem sample_problem(int num_bricks) {
    auto body = std::make_shared<core::Body>();
    body->name = "box";
    body->mesh = box_mesh({0.2, 0.1, 0.1}, {num_bricks, 1, 1});
    body->assumptions = {"the box is taken to be in m"};
    body->patch_confidence = 0.625;
    body->axes.from_lps << 0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0;
    body->mesh.region_names = {"parenchyma", "tumour"};
    body->mesh.region.back() = 1;
    body->materials = {{1060.0, 4000.0, 0.45}, {1100.0, 20000.0, 0.48}};

    core::LoadCase load_case = empty_load_case(body->mesh);
    load_case.name = "pull_and_hang";
    load_case.title = "Held at one side, pulled at the other, µ-gravity";
    load_case.definition = "title = \"Held\"\n# [constraint]\n";
    load_case.target_peak_displacement = 2e-3;
    load_case.load_scale = 1.0 / 3.0;
    prescribe(load_case, body->mesh, "x_min", {0.0, 0.0, 0.0});
    prescribe(load_case, body->mesh, "z_max", {nan, nan, 1e-3});
    pull(load_case, body->mesh, "x_max", {120.0, 0.0, -3.0});
    load_case.conditions.back().kind = core::ConditionKind::pressure;
    for (int e = 2, f = load_case.num_facets() - 1; e <= 9; --f) // and nothing pulls there
        if (load_case.is_free(f)) {
            load_case.put({"glove " + std::to_string(e), core::ConditionKind::traction,
                           core::RoundLoad{{1.0 / 3.0, 0.1 * (e - 1), -0.2}, 0.07 * (e - 1)}},
                          std::array{f}, core::Vector3::Zero());
            ++e;
        }
    load_case.acceleration = {0.0, 0.0, -9.81};
    load_case.press_depth = 2e-3; // and nowhere does anything press
    load_case.path = {0.2, 0.4, 0.6, 0.8, 1.0};
    load_case.node_factor.assign(body->mesh.points.size(), 1.0);
    load_case.node_factor.back() = 0.5;
    load_case.node_shift.assign(body->mesh.points.size(), core::Vector3::Zero());
    load_case.node_shift.front() = {0.001, 0.0, -0.002};
    for (int y = 1; y <= 7; ++y)
        load_case.yielded.push_back({"jaw " + std::to_string(y), 0.03 * y});
    load_case.touching = core::TouchingTool{.shape = 0.3,
                                            .start = {0.5, 0.5, 1.3},
                                            .press = {0.0, 0.01, -1.0 / 70.0},
                                            .slide = {0.1, 0.0, 0.0},
                                            .friction = 1.0 / 3.0,
                                            .constraint = 1};
    load_case.foundation = tests::even_foundation({0, 1, 2, 3, 5, 6, 7, 8, 9, 10, 11}, 1e6 / 7.0, true);
    load_case.release = core::Release{52, 0.01, {1.5, 1e-4}, {{"tip", 3}, {"dome", 0}, {"edge", 5}}};
    return {std::move(body), std::move(load_case)};
}

/// u = scale * x, of which no two nodes have the same.
core::Solution stretched(const core::Problem &problem, double scale) {
    core::Solution solution;
    for (const core::Vector3 &point : problem.body->mesh.points)
        solution.displacement.emplace_back(scale * (point + core::Vector3(0.01, 0.02, 0.03)));
    solution.reaction = {{scale, -1.0 / 3.0, 0.1}, {0.0, 0.0, 7.0 * scale}};
    solution.strain_energy = 0.5 * scale * scale;
    solution.degrees_of_freedom = 3 * static_cast<std::int64_t>(solution.displacement.size());
    solution.setup_seconds = 0.25;
    solution.solve_seconds = 1.0 / 3.0;
    return solution;
}

/// On the way there, a little ahead of the load.
std::vector<core::PathPoint> path_to(const core::Solution &solution, const std::vector<double> &fractions) {
    std::vector<core::PathPoint> path;
    for (const double fraction : fractions) {
        auto &point = path.emplace_back();
        for (const auto &displacement : solution.displacement)
            point.displacement.push_back((std::sqrt(fraction) * displacement).cast<float>());
        for (const auto &reaction : solution.reaction)
            point.reaction.emplace_back(std::sqrt(fraction) * reaction);
        point.strain_energy = fraction * solution.strain_energy;
    }
    return path;
}

/// Motion of the probes with all entries different.
core::History swinging(const core::Release &release, int num_nodes, double scale) {
    core::History history;
    history.setup_seconds = 0.5;
    history.solve_seconds = 1.0 / 7.0;
    history.integrator = "pendulum clock";
    history.kernel = "escapement";
    history.forces_per_step = 3;
    history.time_step = 0.3 * release.output_interval;
    history.critical_time_step = 0.7;
    for (int k = 0; k <= release.num_steps; ++k) {
        history.time.push_back(k * release.output_interval);
        history.kinetic_energy.push_back(0.1 * k);
        history.strain_energy.push_back(1.0 - 0.11 * k);
        for (std::size_t q = 0; q < release.probes.size(); ++q)
            history.displacement.emplace_back(scale * core::Vector3(k + 1.0, 0.1 * static_cast<double>(q), k / 3.0));
        for (int i = 0; release.is_frame(k) && i < num_nodes; ++i)
            history.frames.emplace_back((scale * core::Vector3(i / 3.0, k + 0.1, 0.2 * i)).cast<float>());
    }
    return history;
}

core::Modes some_modes(const core::TetraMesh &mesh) {
    core::Modes modes{{1.0, 4.0 / 3.0, 7.0, 9.5}, {}, 36, 0.75};
    for (int mode = 0; mode < modes.count(); ++mode)
        for (const auto &point : mesh.points)
            modes.shape.emplace_back((mode + 0.1) * (point + core::Vector3(1.0, 2.0, 3.0)));
    return modes;
}

core::SpringNetwork springs_of(const core::TetraMesh &mesh) {
    core::SpringNetwork springs;
    springs.node_mass = core::nodal_volumes(mesh);
    springs.edges = core::edge_table(mesh.tetrahedra).edges;
    for (const auto &[i, j] : springs.edges) {
        springs.rest_length.push_back((mesh.points[i] - mesh.points[j]).norm());
        springs.stiffness.push_back(100.0 + i + 0.1 * j);
    }
    return springs;
}

/// Says of what was solved along a path that as many times have passed there, which takes no other solution.
void add_slow_history(results::Result &result) {
    auto &history = result.problem.load_case.slow_history.emplace();
    history.relaxation.name = "dough";
    for (int b = 1; b <= 13; ++b) {
        history.relaxation.moduli.push_back(0.005 * b);
        history.relaxation.times.push_back(0.3 * b);
    }
    history.times = {0.0, 0.5, 1.0, 2.0, 4.0};
    history.factors = {0.0, 1.0, 0.0, 0.75, 0.25};
    history.last_cycle = 2;
    for (auto &model : result.models) {
        for (auto &point : model.solution.path) {
            point.work = 3.0 * point.strain_energy;
            point.dissipated_energy = 1.0 / 7.0 + point.strain_energy;
        }
        if (model.comparison)
            model.comparison->slow = core::SlowComparison{0.01, 1.0 / 3.0, "x_max", -0.2};
    }
}

} // namespace

results::Result sample_result(int num_bricks) {
    results::Result result;
    result.provenance = {"0.1.0",
                         "0123abc-dirty",
                         "2026-11-21T08:00:00Z",
                         "livermark run --body box",
                         "A processor",
                         "GNU 12.2.0",
                         "Release",
                         4};
    result.problem = sample_problem(num_bricks);
    const core::TetraMesh &mesh = result.problem.body->mesh;
    const core::Release &release = *result.problem.load_case.release;
    core::Solution reference = stretched(result.problem, 0.01);
    reference.observed_error = core::ObservedError{1.1, 0.004, 0.003, 0.002, 0.001, 0.6, 0.007};
    reference.path = path_to(reference, result.problem.load_case.path);
    reference.history = swinging(release, mesh.num_nodes(), 0.01);
    reference.history->observed_error = core::ObservedMotionError{1.2, 0.04, 0.03};
    result.models.push_back({"fem_p2", "Quadratic tetrahedra", "Hughes 1987", reference, std::nullopt});
    result.models.back().solution.solver = "CHOLMOD";

    core::Solution springs = stretched(result.problem, 0.012);
    springs.nonlinearity = 0.03;
    springs.load_work = 0.002;
    springs.explicit_steps = {0.004, 1.5e-4, "simd_float"};
    springs.springs = springs_of(mesh);
    springs.path = path_to(springs, result.problem.load_case.path);
    springs.history = swinging(release, mesh.num_nodes(), 0.012);
    auto comparison = core::compare(mesh, result.problem.load_case, springs, reference, "fem_p2");
    comparison.history = core::compare(*springs.history, *reference.history, "fem_p2");
    result.models.push_back({"springs", "Springs", "Lloyd 2007", springs, comparison});

    core::Solution blown_up = stretched(result.problem, 1e30);
    blown_up.status = core::SolutionStatus::diverged;
    blown_up.message = "a node left the room";
    blown_up.displacement.front() = {nan, std::numeric_limits<double>::infinity(), -1.0};
    result.models.push_back({"blown_up", "Explodes", "", blown_up,
                             core::compare(mesh, result.problem.load_case, blown_up, reference, "fem_p2")});

    core::Solution unfinished = stretched(result.problem, 0.005);
    unfinished.status = core::SolutionStatus::not_converged;
    unfinished.message = "100 iterations were not enough";
    result.models.push_back({"unfinished", "Slow", "", unfinished, std::nullopt});
    result.reference_uncertainty = {.reference = "fem_p2",
                                    .refined = "springs",
                                    .refinement_difference = 1.0 / 3.0,
                                    .order = 1.0,
                                    .relative_l2 = 0.19,
                                    .energy_error = 0.02,
                                    .reaction_error = 0.01,
                                    .stiffness = 0.008};
    result.motion_uncertainty = {
        .reference = "fem_p2", .refined = "springs", .difference = 0.05, .order = 1.2, .relative_l2 = 0.08};
    result.modes.push_back({"fem_p2", some_modes(mesh)});
    add_slow_history(result);
    return result;
}

results::ModelResult stiffer(results::ModelResult model) {
    model.name = "stiffer";
    for (double &stiffness : model.solution.springs.value().stiffness)
        stiffness *= 2.0;
    return model;
}

results::Result without_motion(results::Result result) {
    result = along_a_path(std::move(result));
    result.modes.clear();
    result.problem.load_case.path.clear();
    for (auto &model : result.models) {
        model.solution.path.clear();
        if (model.comparison && model.comparison->tool)
            for (auto &place : model.comparison->tool->places)
                place.path.clear();
    }
    return result;
}

namespace {

/// As many places as the tools of the load case have.
void resize_places_of_tools(results::Result &result) {
    const auto num_places = core::tool_places(result.problem.body->mesh, result.problem.load_case).size();
    for (auto &model : result.models)
        if (model.comparison && model.comparison->tool)
            model.comparison->tool->places.resize(num_places, model.comparison->tool->places.front());
}

} // namespace

results::Result with_jaws(results::Result result) {
    auto &ball = result.problem.load_case.touching.value();
    ball.slide = core::Vector3::Zero();
    ball.constraint = 0;
    ball.between = core::Vector3(0.5, 1.0 / 3.0, -0.7);
    resize_places_of_tools(result);
    return result;
}

results::Result along_a_path(results::Result result) {
    result.problem.load_case.release.reset();
    result.problem.load_case.slow_history.reset();
    result.problem.load_case.touching.reset();
    result.motion_uncertainty.reset();
    resize_places_of_tools(result);
    for (auto &model : result.models) {
        model.solution.history.reset();
        for (auto &point : model.solution.path)
            point.work = point.dissipated_energy = nan;
        if (model.comparison) {
            model.comparison->history.reset();
            model.comparison->slow.reset();
        }
    }
    return result;
}

} // namespace livermark::tests
