// How far a force moves a place of a needle in a frame, by the iterations of each implicit method, over how far
// backward Euler moves it: what coupling by forces that last has to know, see docs/studies/needle_arena.md. No times.
#include <CLI/CLI.hpp>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <string>
#include <vector>

#include "core/tool/needle/moving_needle.hpp"
#include "interactive/inertia.hpp"
#include "interactive/method.hpp"
#include "interactive/place_response.hpp"
#include "msm/elastic_body.hpp"
#include "msm/nodal_conditions.hpp"
#include "studies/needle/needle_problems.hpp"
#include "support/input_error.hpp"

namespace {

namespace core = livermark::core;
namespace interactive = livermark::interactive;
using Weights = Eigen::SparseMatrix<double, Eigen::RowMajor>;

constexpr double mass_damping = 10.0; ///< [1/s], as in the arena
constexpr double farthest = 1e-5;     ///< that backward Euler moves a place [m]

/// W of the responses (3 N, 3 K), along one direction: shape (K, K).
Eigen::MatrixXd at_places(const Eigen::MatrixXf &response, const Weights &weights, Eigen::Index direction) {
    Eigen::MatrixXd result = Eigen::MatrixXd::Zero(weights.rows(), weights.rows());
    for (Eigen::Index j = 0; j < weights.rows(); ++j)
        for (Eigen::Index k = 0; k < weights.rows(); ++k)
            for (Weights::InnerIterator entry(weights, k); entry; ++entry)
                result(k, j) += entry.value() * response(3 * entry.col() + direction, 3 * j + direction);
    return 0.5 * (result + result.transpose());
}

/// The needle gives way too.
void soften(Eigen::MatrixXd &places) {
    constexpr double h = interactive::frame_time;
    places.diagonal().array() += 1.0 / (h * core::needle_stiffness * (h + core::needle_damping_time));
}

/// What a frame under a force on the middle place leaves out of balance, over the force.
double residual_of_frame(interactive::Simulation &simulation, const Weights &weights, double force, int iterations) {
    const auto rest = interactive::rest_positions(simulation.scene());
    interactive::Field forces = interactive::Field::Zero(3, rest.cols());
    for (Weights::InnerIterator entry(weights, weights.rows() / 2); entry; ++entry)
        forces(0, entry.col()) = force * entry.value();
    simulation.set_state(rest, interactive::Field::Zero(3, rest.cols()));
    simulation.set_external_forces(forces);
    const auto terms = interactive::inertia(simulation, interactive::frame_time);
    simulation.step(interactive::frame_time, iterations);
    interactive::Field left = interactive::Field::Zero(3, rest.cols());
    simulation.energy().add_forces(simulation.positions(), left);
    const auto is_free = interactive::free_nodes(simulation.scene());
    double sum = 0.0;
    for (Eigen::Index i = 0; i < rest.cols(); ++i)
        if (is_free[static_cast<std::size_t>(i)])
            sum += (left.col(i) - terms.stiffness[static_cast<std::size_t>(i)] *
                                      (simulation.positions().col(i) - terms.predicted.col(i)))
                       .squaredNorm();
    return std::sqrt(sum) / forces.norm();
}

interactive::Scene scene_of(const core::Problem &problem) {
    interactive::Scene scene{.body = problem.body,
                             .node_mass = livermark::msm::lumped_masses(*problem.body),
                             .constrained_nodes = {},
                             .mass_damping = mass_damping};
    const auto conditions = livermark::msm::nodal_conditions(problem, scene.node_mass);
    for (std::size_t node = 0; node < scene.node_mass.size(); ++node)
        if (conditions.constraint[node][0] >= 0)
            scene.constrained_nodes.push_back(static_cast<int>(node));
    return scene;
}

void print_method(const interactive::Method &method, const interactive::Scene &scene, const Weights &weights,
                  const std::vector<int> &iterations) {
    constexpr double h = interactive::frame_time;
    const auto simulation = method.prepare(scene);
    const auto converged = interactive::place_response(*simulation, h, weights);
    const double force = farthest / (h * h * converged.maxCoeff());
    auto expected = at_places(converged, weights, 0);
    const double of_middle = expected(weights.rows() / 2, weights.rows() / 2);
    soften(expected);
    for (const int each : iterations) {
        auto found =
            at_places(interactive::observed_place_response(*simulation, h, 1, each, weights, force), weights, 0);
        const double middle = found(weights.rows() / 2, weights.rows() / 2) / of_middle;
        soften(found);
        const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> ratios(found, expected, Eigen::EigenvaluesOnly);
        fmt::print("{:22}  {:10}  {:8.2e}  {:6.2f}  {:5.2f} to {:.2f}\n", method.name, each,
                   residual_of_frame(*simulation, weights, force, each), middle, ratios.eigenvalues().minCoeff(),
                   ratios.eigenvalues().maxCoeff());
    }
}

} // namespace

int main(int argc, char **argv) {
    CLI::App app("How far a force on a place of a needle moves it in a frame of one step, over backward Euler");
    std::string body = "liver_healthy", load_case = "nick";
    std::vector<std::string> names;
    std::vector<int> iterations{1, 3, 10, 30, 100, 300};
    app.add_option("--body", body)->capture_default_str();
    app.add_option("--load-case", load_case, "As in 'livermark list needle-load-cases'")->capture_default_str();
    app.add_option("--method", names, "By default all that are not explicit");
    app.add_option("--iterations", iterations)->check(CLI::Range(1, 100000))->capture_default_str();
    CLI11_PARSE(app, argc, argv);
    try {
        std::vector<std::string> notes;
        const auto problems = livermark::studies::read_with_needles(
            {.bodies = {body}, .load_case = load_case, .models = {}, .material = {}, .output = {}}, notes);
        const auto &[problem, needles] = problems.front();
        const auto weights = core::place_weights(needles.front(), problem.body->mesh);
        const auto scene = scene_of(problem);
        fmt::print("{}: {}, {} places, one step of {:.1f} ms\n", body, needles.front().name, weights.rows(),
                   1e3 * interactive::frame_time);
        fmt::print(
            "residual: out of balance over the force; middle: the place in the middle; all: least and largest\n");
        fmt::print("{:22}  {:10}  {:8}  {:6}  {}\n", "method", "iterations", "residual", "middle", "all");
        for (const auto &method : interactive::all_methods())
            if (!method.is_explicit && (names.empty() || std::ranges::find(names, method.name) != names.end()))
                print_method(method, scene, weights, iterations);
    } catch (const livermark::support::InputError &error) {
        fmt::print(stderr, "{}\n", error.what());
        return 2;
    }
    return 0;
}
