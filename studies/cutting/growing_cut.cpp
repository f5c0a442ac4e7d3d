#include "studies/cutting/cut_study.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <limits>
#include <map>
#include <utility>

#include "core/mesh/refinement.hpp"
#include "core/stopwatch.hpp"
#include "core/support/input_error.hpp"
#include "core/tool/tool_stiffness.hpp"
#include "meshes/cutting/cut.hpp"
#include "meshes/io/mesh_checks.hpp"
#include "studies/arena/arena.hpp"
#include "studies/arena/arena_run.hpp"
#include "studies/models/motion/moving_method.hpp"

namespace livermark::studies {

namespace {

double wound_area(const core::TetraMesh &mesh) {
    double area = 0.0;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (mesh.patch_names[mesh.boundary_patch[f]] == core::wound_patch)
            area += core::area_vector(mesh, f).norm();
    return area;
}

/// Nodes of the wound that are in one place at rest.
std::vector<std::array<int, 2>> parted_nodes(const core::TetraMesh &mesh) {
    std::map<std::array<double, 3>, std::vector<int>> at_place;
    std::vector<bool> is_seen(mesh.points.size(), false);
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (mesh.patch_names[mesh.boundary_patch[f]] == core::wound_patch)
            for (const int node : mesh.boundary_triangles[f])
                if (!is_seen[node]) {
                    is_seen[node] = true;
                    const auto &point = mesh.points[node];
                    at_place[{point.x(), point.y(), point.z()}].push_back(node);
                }
    std::vector<std::array<int, 2>> pairs;
    for (const auto &[place, nodes] : at_place)
        for (std::size_t k = 1; k < nodes.size(); ++k)
            pairs.push_back({nodes[0], nodes[k]});
    return pairs;
}

/// Edges behind the blade's edge at which a body that has moved is still cut: a face that could not be parted while the
/// cut ended at it is parted later. Further behind the wound is open, and the blade may be where other tissue is now.
constexpr double edges_behind = 2.0;

/// The body cut where it is now, and back at rest: along facets, corners keep their order.
meshes::CutBody cut_where_it_is(const core::Body &body, const std::vector<core::Vector3> &displacement,
                                const meshes::Cut &cut) {
    auto moved = body;
    for (std::size_t i = 0; i < displacement.size(); ++i)
        moved.mesh.points[i] += displacement[i];
    auto result = meshes::cut(moved, cut);
    auto &mesh = result.body.mesh;
    const auto &parents = result.parents.front();
    for (std::size_t t = 0; t < parents.size(); ++t)
        for (std::size_t k = 0; k < 4; ++k)
            mesh.points[mesh.tetrahedra[t][k]] = body.mesh.points[body.mesh.tetrahedra[parents[t]][k]];
    return result;
}

/// Along the way of the edge's middle, mean of the nodes at the rim [m].
double rim_depth(const core::TetraMesh &mesh, const BladeWay &way) {
    const auto &[a, b, c, d] = way.corners;
    const core::Vector3 start = 0.5 * (a + b), along = (c + d - a - b).normalized();
    const auto is_rim = wound_rim_nodes(mesh);
    double sum = 0.0;
    int count = 0;
    for (std::size_t i = 0; i < is_rim.size(); ++i)
        if (is_rim[i]) {
            sum += (mesh.points[i] - start).dot(along);
            ++count;
        }
    return sum / count;
}

using models::Effort;

constexpr const char *all_under_blade = "all";
constexpr int most_frames_per_step = 1000;

/// Methods that can be cut, in the order of the table.
std::vector<models::MovingMethod> methods_under_blade() {
    auto methods = models::all_moving_methods();
    std::erase_if(methods, [](const models::MovingMethod &method) { return method.is_scaled; });
    return methods;
}

class MotionUnderBlade {
  public:
    MotionUnderBlade(const models::MovingMethod &method, const models::FramesUnderBlade &frames, int frames_per_step,
                     const std::vector<CutStage> &stages, const std::vector<core::Problem> &problems,
                     const std::vector<models::NodalProblem> &on_nodes)
        : method_(&method), frames_(frames), frames_per_step_(frames_per_step), stages_(&stages), problems_(&problems),
          on_nodes_(&on_nodes) {}

    results::CutMotion run(const Effort &effort, const char *setting, double budget) {
        results::CutMotion motion{.method = method_->name,
                                  .setting = setting,
                                  .budget = budget,
                                  .steps = effort.steps,
                                  .iterations = effort.iterations};
        const std::size_t num_records = stages_->size();
        motion.ready_seconds.assign(num_records, 0.0);
        TimedBody moving([&] { return method_->under_blade(on_nodes_->front(), frames_); }, effort,
                         stages_->front().body->mesh.points);
        double worst = 0.0;
        const auto move = [&](int num_frames, double before = 0.0) { // the time of a cut counts for the frame after it
            for (int f = 0; f < num_frames; ++f) {
                moving.advance();
                worst = std::max(worst, moving.frame_seconds().back() + std::exchange(before, 0.0));
            }
        };
        move(frames_to_rest);
        record(motion, moving, 0);
        for (std::size_t k = 1; k < num_records; ++k) {
            if (!(*stages_)[k].parents.empty())
                motion.ready_seconds[k] =
                    moving.time([&](models::FrameBody &body) { body.cut((*on_nodes_)[k], (*stages_)[k].parents); });
            move(frames_per_step_, motion.ready_seconds[k]);
            if (k + 1 == num_records)
                move(frames_to_rest);
            if (!record(motion, moving, k))
                break;
        }
        for (auto *row : {&motion.opening, &motion.tool_stiffness})
            row->resize(num_records, std::numeric_limits<double>::quiet_NaN());
        motion.setup_seconds = moving.setup_seconds();
        motion.frame_seconds = results::median(moving.frame_seconds());
        motion.worst_frame_seconds = worst;
        return motion;
    }

  private:
    /// @return whether the body is within bounds
    bool record(results::CutMotion &motion, TimedBody &moving, std::size_t k) const {
        if (!moving.is_within_bounds())
            return false;
        core::Solution solution;
        solution.displacement = moving.displacement();
        motion.opening.push_back(opening((*stages_)[k], solution.displacement));
        motion.tool_stiffness.push_back(stiffness_at_first_tool((*problems_)[k], solution));
        return true;
    }

    const models::MovingMethod *method_;
    models::FramesUnderBlade frames_;
    int frames_per_step_;
    const std::vector<CutStage> *stages_;
    const std::vector<core::Problem> *problems_;
    const std::vector<models::NodalProblem> *on_nodes_;
};

bool has_ended_within_bounds(const results::CutMotion &motion) {
    return motion.opening.back() == motion.opening.back(); // no NaN
}

} // namespace

double BladeWay::depth() const {
    return 0.5 * (corners[3] + corners[2] - corners[0] - corners[1]).norm();
}

std::array<core::Vector3, 4> BladeWay::swept(double from, double to) const {
    const auto at = [&](int begin, int end, double part) -> core::Vector3 {
        return (1.0 - part) * corners[begin] + part * corners[end];
    };
    return {at(0, 3, from), at(1, 2, from), at(1, 2, to), at(0, 3, to)};
}

std::vector<CutStage> grow_cut(std::shared_ptr<const core::Body> body, const BladeWay &way,
                               const DisplacementOf &displacement_of) {
    const double before = wound_area(body->mesh); // of cuts that were there
    const double behind = edges_behind * meshes::mesh_figures(body->mesh).mean_edge / way.depth();
    std::vector<CutStage> stages{{.body = std::move(body)}};
    for (int step = 0; step < way.num_steps; ++step) {
        const auto &last = stages.back();
        const double from = displacement_of ? std::max(0.0, double(step) / way.num_steps - behind) : 0.0;
        const meshes::Cut cut{.tool = meshes::BladeCut{way.swept(from, double(step + 1) / way.num_steps)},
                              .place = "the blade"};
        auto next = last;
        next.parents.clear();
        next.depth = way.depth() * (step + 1) / way.num_steps;
        const auto displacement = displacement_of ? displacement_of(last) : std::vector<core::Vector3>{};
        const double start = core::processor_seconds();
        try {
            auto result = cut_where_it_is(*last.body, displacement, cut);
            next.parents = std::move(result.parents.front());
            next.body = std::make_shared<const core::Body>(std::move(result.body));
        } catch (const meshes::CutMissesBody &) {
            // nothing to part in this step
        } catch (const meshes::CutNotOnBody &error) {
            throw meshes::CutNotOnBody(fmt::format("the blade, {:.3g} mm deep", 1e3 * next.depth), error.reason(),
                                       "let it end before that, or go in elsewhere");
        }
        next.seconds = core::processor_seconds() - start;
        if (next.body != last.body) {
            next.area = 0.5 * (wound_area(next.body->mesh) - before);
            next.parted = parted_nodes(next.body->mesh);
        }
        stages.push_back(std::move(next));
    }
    if (stages.back().area == 0.0)
        throw meshes::CutMissesBody("the blade", "it parts no face of a tetrahedron on its way",
                                    "let it go through the body, and where that is not cut yet");
    return stages;
}

CutStage cut_exactly(const core::Body &body, const BladeWay &way) {
    auto result = meshes::cut(
        body, {.tool = meshes::BladeCut{way.corners}, .way = meshes::CutWay::exact, .place = "the blade, exactly"});
    const auto &mesh = result.body.mesh;
    CutStage stage{.body = {},
                   .depth = way.depth(),
                   .area = 0.5 * (wound_area(mesh) - wound_area(body.mesh)),
                   .parted = parted_nodes(mesh)};
    stage.body = std::make_shared<const core::Body>(std::move(result.body));
    return stage;
}

double opening(const CutStage &stage, const std::vector<core::Vector3> &displacement) {
    double widest = 0.0;
    for (const auto &[one, other] : stage.parted)
        widest = std::max(widest, (displacement[one] - displacement[other]).norm());
    return widest;
}

double stiffness_at_first_tool(const core::Problem &problem, const core::Solution &solution) {
    const auto &mesh = problem.body->mesh;
    const auto places = core::tool_places(mesh, problem.load_case);
    return places.empty() ? std::numeric_limits<double>::quiet_NaN()
                          : core::stiffness_at(mesh, problem.load_case, places, 0, solution);
}

std::vector<bool> wound_rim_nodes(const core::TetraMesh &mesh) {
    constexpr double folded = -1.0 + 1e-9; // cosine between the outward normals of the two sides
    std::map<std::array<int, 2>, core::Vector3> normal_at;
    std::vector<bool> is_rim(mesh.points.size(), false);
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f) {
        if (mesh.patch_names[mesh.boundary_patch[f]] != core::wound_patch)
            continue;
        const core::Vector3 normal = core::area_vector(mesh, f).normalized();
        const auto &nodes = mesh.boundary_triangles[f];
        for (std::size_t k = 0; k < 3; ++k) {
            const int a = nodes[k], b = nodes[(k + 1) % 3];
            const auto [other, is_first] = normal_at.try_emplace({std::min(a, b), std::max(a, b)}, normal);
            if (!is_first && normal.dot(other->second) < folded)
                is_rim[a] = is_rim[b] = true;
        }
    }
    return is_rim;
}

std::vector<results::CutLevel> solve_finer_at_wound(const core::Model &model, const BladeWay &way,
                                                    const std::string &cut, const CutStage &stage,
                                                    const core::Problem &problem, int times,
                                                    const std::function<void()> &begins, std::string &failure) {
    std::vector<results::CutLevel> levels;
    auto refined = problem;
    const double depth = rim_depth(stage.body->mesh, way);
    for (int level = 0; level <= times; ++level) {
        begins();
        if (level > 0)
            refined = core::refine_at_rims_and(refined, wound_rim_nodes(refined.body->mesh)).problem;
        const auto solution = model.solve(refined);
        if (solution.status != core::SolutionStatus::ok) {
            failure = solution.message;
            break;
        }
        levels.push_back({.way = cut,
                          .tetrahedra = refined.body->mesh.num_tetrahedra(),
                          .area = stage.area,
                          .depth = depth,
                          .opening = opening(stage, solution.displacement),
                          .tool_stiffness = stiffness_at_first_tool(refined, solution),
                          .solve_seconds = solution.setup_seconds + solution.solve_seconds});
    }
    return levels;
}

std::vector<std::string> chosen_methods_under_blade(const CutMotionOptions &options) {
    const auto methods = methods_under_blade();
    std::vector<std::string> chosen;
    for (const auto &name : options.methods)
        if (name != all_under_blade)
            support::find_named(methods, name, "method");
    for (const auto &method : methods)
        if (std::ranges::any_of(options.methods, [&](const std::string &name) {
                return name == method.name || name == all_under_blade;
            }))
            chosen.push_back(method.name);
    if (chosen.empty())
        return chosen;
    if (options.budgets.empty() || !std::ranges::all_of(options.budgets, [](double budget) { return budget > 0.0; }))
        throw support::InputError("--budget is empty or has a time that is not above 0 ms; give times above 0");
    if (options.frames_per_step < 1 || options.frames_per_step > most_frames_per_step)
        throw support::InputError(
            fmt::format("--frames is {}; give 1 to {}", options.frames_per_step, most_frames_per_step));
    return chosen;
}

void check_loads_of_motion(const core::Problem &problem) {
    refuse_single_components(problem.load_case);
    for (const core::Vector3 &displacement : models::on_nodes(problem).conditions.displacement) {
        const bool is_constrained = !displacement.array().isNaN().any();
        if (is_constrained && !displacement.isZero(0.0))
            throw support::InputError(fmt::format("load case {} displaces a place, which would jump when the motion "
                                                  "begins; choose one with tractions or forces for --method",
                                                  problem.load_case.name));
    }
}

std::vector<results::CutMotion> move_under_blade(const CutMotionOptions &options, const std::vector<CutStage> &stages,
                                                 const std::vector<core::Problem> &problems,
                                                 const ProgressReport &report) {
    const models::FramesUnderBlade frames;
    auto budgets = options.budgets;
    std::ranges::sort(budgets);
    const auto names = chosen_methods_under_blade(options);
    std::vector<models::NodalProblem> on_nodes;
    for (std::size_t k = 0; k < problems.size(); ++k)
        on_nodes.push_back(k > 0 && stages[k].parents.empty() ? on_nodes.back() : models::on_nodes(problems[k]));
    std::vector<results::CutMotion> motions;
    Steps steps(static_cast<int>(names.size()), report);
    const auto all_methods = methods_under_blade();
    for (const auto &name : names) {
        steps.next(fmt::format("{} / {} moves under the blade", problems.front().body->name, name));
        const auto &method = support::find_named(all_methods, name, "method");
        MotionUnderBlade motion(method, frames, options.frames_per_step, stages, problems, on_nodes);
        const auto measured = method.under_blade(on_nodes.front(), frames);
        if (const auto least = measured->least_effort()) {
            auto run = motion.run(*least, stable_setting, 0.0);
            // What is stable at rest need not be so at a wound.
            if (!has_ended_within_bounds(run))
                run = motion.run(twice(*least), half_steps_setting, 0.0);
            const auto fits = std::ranges::lower_bound(budgets, run.frame_seconds);
            run.budget = fits == budgets.end() ? budgets.back() : *fits;
            motions.push_back(std::move(run));
            continue;
        }
        const auto frame = [&](const Effort &effort) { measured->advance({}, effort); };
        for (const double budget : budgets)
            for (const auto setting : models::all_settings)
                if (const auto fits = largest_effort(frame, setting, budget))
                    motions.push_back(motion.run(fits->effort, models::to_string(setting), budget));
    }
    return motions;
}

} // namespace livermark::studies
