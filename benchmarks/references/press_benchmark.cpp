// No times: what happens below a round tool of large load cases on finer and finer meshes, and whether the surface
// there is still stable.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <memory>
#include <numeric>
#include <string>
#include <vector>

#include <Eigen/LU>

#include "core/mesh/local_refinement.hpp"
#include "core/units.hpp"
#include "fem_reference/dof_conditions.hpp"
#include "fem_reference/hyperelastic/paths/load_path.hpp"
#include "fem_reference/hyperelastic/paths/path_system.hpp"
#include "fem_reference/hyperelastic/surface/surface_deformation.hpp"
#include "fem_reference/hyperelastic/surface/surface_impedance.hpp"
#include "fem_reference/hyperelastic/tangent_solver.hpp"
#include "studies/run/problems.hpp"
#include "support/input_error.hpp"

namespace livermark {
namespace {

using core::Vector3;
using hyperelastic::Elements;
using hyperelastic::SurfacePoint;

struct Options {
    std::string body = "liver_healthy", load_case = "large_indentation";
    double poisson_ratio = std::numeric_limits<double>::quiet_NaN();
    double longest_edge = core::longest_edge_below_tools;
    double force = 0.0; ///< [N]
    double until = 1.0; ///< part of the depth or force
    int first_level = 0, num_levels = 3, num_parts = 10, num_modes = 2;
    bool at_rims = false;
};

constexpr double percent = 100.0, millimetres = 1e3;

/// What holds below the tools in one state.
struct BelowTools {
    double least_under = 1.0, least_beside = 1.0;                     ///< stretches of the surface
    double largest_pressure = 0.0;                                    ///< at rest, over the shear modulus
    double least_impedance = std::numeric_limits<double>::infinity(); ///< over the shear modulus
    double least_following = std::numeric_limits<double>::infinity(); ///< the same under pressures that follow
    double unstable = 0.0, pressed = 0.0;                             ///< areas [m^2]
};

BelowTools look_below(const core::Problem &problem, const std::vector<SurfacePoint> &surface,
                      const hyperelastic::MaterialLaw &law, double force) {
    BelowTools result;
    const auto tools = problem.load_case.round_loads();
    for (int f = 0; f < problem.load_case.num_facets(); ++f) {
        const auto &point = surface[f];
        const bool is_near = std::ranges::any_of(
            tools, [&](const auto &tool) { return (point.at_rest - tool.middle).norm() < 2.0 * tool.radius; });
        const auto *tool = problem.load_case.round_load_on(f);
        if (!is_near || (!tool && !problem.load_case.is_free(f)))
            continue;
        const double stretch = hyperelastic::surface_stretches(point).least;
        auto &least = tool ? result.least_under : result.least_beside;
        least = std::min(least, stretch);
        const double mu = point.material.shear_modulus();
        const Vector3 dead = tool ? Vector3(force * problem.load_case.value[f]) : Vector3::Zero();
        const auto f_here = hyperelastic::under_traction(law, point, dead);
        if (!f_here.allFinite()) {
            fmt::print("no F on facet {}\n", f);
            continue;
        }
        auto tangent = hyperelastic::whole_tangent(law, point.material, f_here);
        const double impedance = hyperelastic::least_surface_impedance(tangent, point.normal) / mu;
        result.least_impedance = impedance < result.least_impedance ? impedance : result.least_impedance;
        const double traction = dead.norm();
        const double stretched_area = f_here.determinant() * (f_here.inverse().transpose() * point.normal).norm();
        hyperelastic::add_follower_pressure(traction / stretched_area, f_here, tangent);
        const double following = hyperelastic::least_surface_impedance(tangent, point.normal) / mu;
        result.least_following = following < result.least_following ? following : result.least_following;
        if (tool) {
            result.largest_pressure = std::max(result.largest_pressure, traction / mu);
            result.pressed += point.area;
            result.unstable += impedance > 0.0 ? 0.0 : point.area;
        }
    }
    return result;
}

/// Whether the tangent is positive definite on what is free, and where the mode of its least eigenvalue is: of elements
/// in displacements alone, at the state of the mixed ones, because its factor is that of all unknowns.
struct Mode {
    bool is_definite = true;
    double below_tools = 0.0; ///< part of its square within a radius of a tool
};

Mode least_mode(const core::Problem &problem, const hyperelastic::MaterialLaw &law,
                const fem_reference::DofConditions &conditions, const std::vector<double> &displacement) {
    const Elements elements(problem.body, 2, fem_reference::Formulation::displacement, law,
                            hyperelastic::TetrahedronRule::fourteen_points);
    auto tangent = elements.zero_tangent();
    const hyperelastic::State state{displacement, {}};
    elements.assemble_tangent(state, tangent);
    hyperelastic::TangentSolver solver(elements, hyperelastic::free_of(conditions.prescribed));
    Mode mode{.is_definite = solver.factorise(tangent.stiffness)};
    if (mode.is_definite)
        return mode;
    // Inverse iterations with as much added to the diagonal as makes it definite.
    constexpr double small_area = 1e-6; // [m^2]
    double shift = small_area * solver.pressure_scale();
    auto shifted = tangent;
    for (double added = 0.0; !solver.factorise(shifted.stiffness); shift *= 4.0) {
        for (auto &block : shifted.stiffness.diagonal)
            for (const int i : {0, 4, 8})
                block[i] += shift - added;
        added = shift;
    }
    hyperelastic::State x{std::vector<double>(displacement.size(), 0.0), {}};
    for (std::size_t dof = 0; dof < displacement.size(); ++dof)
        x.displacement[dof] = std::sin(1.7 * static_cast<double>(dof));
    for (int iteration = 0; iteration < 15; ++iteration) {
        auto next = solver.solve(shifted, {}, x, 1e-6).change;
        const double size = std::sqrt(
            std::inner_product(next.displacement.begin(), next.displacement.end(), next.displacement.begin(), 0.0));
        for (double &value : next.displacement)
            value /= size;
        x = std::move(next);
    }
    for (std::size_t node = 0; node < elements.system().points.size(); ++node)
        for (const auto &tool : problem.load_case.round_loads())
            if ((elements.system().points[node] - tool.middle).norm() < tool.radius)
                mode.below_tools += Vector3::Map(&x.displacement[3 * node]).squaredNorm();
    return mode;
}

void follow(const core::Problem &problem, const Options &options, int level) {
    const auto &law = hyperelastic::material_law("neo_hookean");
    const auto &mesh = problem.body->mesh;
    const Elements elements(problem.body, 2, fem_reference::Formulation::mixed, law,
                            hyperelastic::TetrahedronRule::fourteen_points);
    auto conditions = fem_reference::dof_conditions(problem.load_case, elements.system());
    const auto depth_of = [load = conditions.load](const std::vector<double> &displacement) {
        return std::inner_product(load.begin(), load.end(), displacement.begin(), 0.0);
    };
    std::vector<double> pressure;
    if (options.force > 0.0) {
        pressure.assign(mesh.boundary_triangles.size(), 0.0);
        for (int f = 0; f < problem.load_case.num_facets(); ++f)
            if (problem.load_case.presses(f))
                pressure[f] = options.force * problem.load_case.value[f].norm();
        conditions.press_depth = 0.0;
        std::ranges::fill(conditions.load, 0.0);
    }
    hyperelastic::LoadPath path;
    path.tolerance = 1e-8;
    path.fractions.clear();
    for (int part = 1; part <= options.num_parts; ++part)
        path.fractions.push_back(options.until * part / options.num_parts);
    const auto found = hyperelastic::follow(elements, conditions, problem.load_case.num_constraints(), pressure, path);
    for (const auto &point : found.points) {
        const double force = pressure.empty() ? point.press : options.force * point.fraction;
        const auto below =
            look_below(problem, hyperelastic::surface_points(elements, point.state.displacement), law, force);
        fmt::print(
            "| {} | {} | {:.1f} | {:.3f} | {:.5f} | {:.4f} | {:.3f} | {:.3f} | {:.2f} | {:.2f} | {:.0f} | {:.2f} |\n",
            level, elements.num_displacements() + elements.num_pressures(), percent * point.fraction,
            millimetres * depth_of(point.state.displacement), force, point.smallest_jacobian, below.least_under,
            below.least_beside, below.largest_pressure, below.least_impedance, percent * below.unstable / below.pressed,
            below.least_following);
        std::fflush(stdout);
    }
    fmt::print("level {}: {} {} ({:.0f} s)\n", level, core::to_string(found.status), found.message,
               found.setup_seconds + found.solve_seconds);
    if (options.force > 0.0)
        return;
    const auto num_modes = std::min(found.points.size(), static_cast<std::size_t>(options.num_modes));
    for (std::size_t k = found.points.size() - num_modes; k < found.points.size(); ++k) {
        const auto mode = least_mode(problem, law, conditions, found.points[k].state.displacement);
        fmt::print("level {}, {:.1f} %: tangent {}, {:.0f} % of the mode below the tool\n", level,
                   percent * found.points[k].fraction, mode.is_definite ? "positive definite" : "indefinite",
                   percent * mode.below_tools);
        std::fflush(stdout);
    }
}

void run(const Options &options) {
    meshes::MaterialOverride material;
    if (!std::isnan(options.poisson_ratio))
        material.poisson_ratio = options.poisson_ratio;
    auto problem = studies::read_problems({options.body}, {options.load_case}, material).problems.front();
    fmt::print("| level | unknowns | depth [%] | depth [mm] | force [N] | min J | least stretch under | beside | "
               "pressure / mu "
               "| least Z / mu | unstable area [%] | least Z / mu if it follows |\n");
    for (int level = 0; level < options.num_levels; ++level) {
        if (level > 0)
            problem = options.at_rims ? core::refine_at_rims(problem).problem
                                      : core::refine_at_rims_and_tools(problem, options.longest_edge).problem;
        if (level >= options.first_level)
            follow(problem, options, level);
    }
}

int start(int argc, char **argv) {
    Options options;
    CLI::App app("The surface below round tools of a large load case, on finer and finer meshes");
    app.add_option("--body", options.body)->capture_default_str();
    app.add_option("--load-case", options.load_case, "A large one whose tools press")->capture_default_str();
    app.add_option("--poisson", options.poisson_ratio, "Of all regions");
    app.add_option("--edge", options.longest_edge, "Longest edge below tools, see core::refine_at_rims_and_tools()")
        ->capture_default_str();
    app.add_option("--levels", options.num_levels)->capture_default_str()->check(CLI::Range(1, 5));
    app.add_option("--parts", options.num_parts, "Points of the path")
        ->capture_default_str()
        ->check(CLI::Range(1, 100));
    app.add_option("--follow", options.force,
                   "Pressures that follow the surface instead, up to this force at rest [N]");
    app.add_option("--until", options.until, "Part of the depth or force where the path ends; above 1 it goes on")
        ->capture_default_str()
        ->check(CLI::Range(0.01, 3.0));
    app.add_flag("--rims", options.at_rims, "Refine at rims only");
    app.add_option("--first", options.first_level, "First level to solve on")->capture_default_str();
    app.add_option("--modes", options.num_modes,
                   "At how many points from the last it is looked whether the tangent is positive definite")
        ->capture_default_str();
    CLI11_PARSE(app, argc, argv);
    try {
        run(options);
    } catch (const support::InputError &error) {
        fmt::print(stderr, "{}\n", error.what());
        return 2;
    }
    return 0;
}

} // namespace
} // namespace livermark

int main(int argc, char **argv) {
    return livermark::start(argc, argv);
}
