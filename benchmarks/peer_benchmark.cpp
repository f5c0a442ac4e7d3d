// Time of the same work by a method of interactive/ and by Bullet, as bullet/<work>/<body>; see README.md.
#include "benchmarks/peers/bullet_scene.hpp"

#include <BulletSoftBody/btDeformableLinearElasticityForce.h>
#include <BulletSoftBody/btDeformableMassSpringForce.h>
#include <BulletSoftBody/btDeformableNeoHookeanForce.h>
#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "benchmarks/harness.hpp"
#include "core/stopwatch.hpp"
#include "interactive/elements/explicit_tetrahedra.hpp"
#include "interactive/elements/implicit_elements.hpp"
#include "interactive/method.hpp"

namespace livermark::benchmarks {

namespace {

using interactive::Field;
using interactive::Simulation;

constexpr double frame = interactive::frame_time;

/// A body that an interactive method and Bullet both move: constrained at its back, stretched by 1 % along x
/// and let go from rest.
struct MovingScene {
    interactive::Scene scene;
    Field start;   ///< shape (3, N) [m]
    Field targets; ///< shape (3, C) of the constrained nodes, where they start [m]
};

/// A method that does the same work again and again.
struct Side {
    std::function<void()> reset; ///< back to the start
    std::function<void()> work;  ///< one step, or one evaluation of forces
    /// Positions after a step [m], less those at the start, or forces [N]. shape (3, N)
    std::function<Field()> result;
};

struct Sides {
    Side ours, bullet;
};

/// The same work by a method of ours and by Bullet.
struct Comparison {
    std::string name;
    int iterations = 1; ///< in what is timed
    /// @param is_check  with as many iterations as make both come to one result
    std::function<Sides(const MovingScene &, bool is_check)> make;
    double tolerance = 0.0; ///< of the difference between these results, relative to ours
};

Field at_rest(const MovingScene &moving) {
    return Field::Zero(3, moving.start.cols());
}

Side steps_of(const std::shared_ptr<Simulation> &simulation, const MovingScene &moving, double time_step,
              int iterations) {
    const auto reset = [simulation, moving] {
        simulation->set_state(moving.start, at_rest(moving));
        simulation->set_targets(moving.targets);
    };
    reset();
    return {.reset = reset,
            .work = [simulation, time_step, iterations] { simulation->step(time_step, iterations); },
            .result = [simulation, moving]() -> Field { return simulation->positions() - moving.start; }};
}

template <class World>
Side steps_of_bullet(const std::shared_ptr<World> &world, const MovingScene &moving, double time_step,
                     int num_steps = 1) {
    const auto reset = [world, moving] { set_state(*world->body, moving.start, at_rest(moving)); };
    reset();
    return {.reset = reset,
            .work =
                [world, time_step, num_steps] {
                    for (int s = 0; s < num_steps; ++s)
                        world->step(time_step);
                },
            .result = [world, moving]() -> Field { return positions_of(*world->body) - moving.start; }};
}

Side forces_of(const std::shared_ptr<interactive::Energy> &energy, const MovingScene &moving) {
    const auto forces = std::make_shared<Field>(at_rest(moving));
    return {.reset = [] {},
            .work =
                [=] {
                    forces->setZero();
                    energy->add_forces(moving.start, *forces);
                },
            .result = [forces] { return *forces; }};
}

/// Work of the deformation gradients, which Bullet takes for all its laws together with the rotations, and of the law.
Side forces_of_bullet(const std::shared_ptr<BulletDeformable> &world, const MovingScene &moving) {
    set_state(*world->body, moving.start, at_rest(moving));
    world->prepare_forces();
    return {.reset = [] {},
            .work = [world] { world->evaluate_forces(); },
            .result = [world] { return world->evaluated_forces(); }};
}

std::shared_ptr<BulletDeformable> tetrahedra_of_bullet(const MovingScene &moving,
                                                       std::unique_ptr<btDeformableLagrangianForce> law,
                                                       const BulletIterations &iterations = {}) {
    auto world = std::make_shared<BulletDeformable>(moving.scene, std::move(law), iterations);
    append_tetrahedra(*world->body, moving.scene.body->mesh);
    return world;
}

std::shared_ptr<BulletDeformable> springs_of_bullet(const MovingScene &moving, const interactive::Springs &springs,
                                                    const BulletIterations &iterations = {}) {
    auto world = std::make_shared<BulletDeformable>(
        moving.scene, std::make_unique<btDeformableMassSpringForce>(static_cast<btScalar>(springs.stiffness[0]), 0.0F),
        iterations);
    append_links(*world->body, springs.edges, {1.0});
    return world;
}

std::unique_ptr<btDeformableLagrangianForce> linear_law(const MovingScene &moving) {
    const auto &material = moving.scene.body->materials[0];
    return std::make_unique<btDeformableLinearElasticityForce>(
        static_cast<btScalar>(material.shear_modulus()), static_cast<btScalar>(material.lame_lambda()), 0.0F, 0.0F);
}

std::unique_ptr<btDeformableLagrangianForce> neo_hookean_law(const MovingScene &moving) {
    const auto &material = moving.scene.body->materials[0];
    const auto law = bullet_laws::NeoHookean::for_small_strains(material.shear_modulus(), material.lame_lambda());
    return std::make_unique<btDeformableNeoHookeanForce>(static_cast<btScalar>(law.mu),
                                                         static_cast<btScalar>(law.lambda), 0.0F);
}

Sides corotational_forces(const MovingScene &moving, bool) {
    return {forces_of(std::make_shared<interactive::ElementEnergy<interactive::densities::Corotational>>(
                          interactive::tetrahedra_at_rest(*moving.scene.body)),
                      moving),
            forces_of_bullet(tetrahedra_of_bullet(moving, linear_law(moving)), moving)};
}

Sides neo_hookean_forces(const MovingScene &moving, bool) {
    return {forces_of(std::make_shared<interactive::ElementEnergy<bullet_laws::NeoHookean>>(
                          tetrahedra_for_bullet(*moving.scene.body)),
                      moving),
            forces_of_bullet(tetrahedra_of_bullet(moving, neo_hookean_law(moving)), moving)};
}

Sides spring_forces(const MovingScene &moving, bool) {
    const auto springs = springs_of_mean_stiffness(*moving.scene.body);
    return {forces_of(std::make_shared<interactive::SpringEnergy>(springs), moving),
            forces_of_bullet(springs_of_bullet(moving, springs), moving)};
}

/// One step moves a body by little more than the last digit of single precision, so twenty are compared.
Sides explicit_neo_hookean_step(const MovingScene &moving, bool is_check) {
    const int steps = is_check ? 20 : 1;
    const double h =
        0.5 * interactive::critical_time_step_bound(tetrahedra_for_bullet(*moving.scene.body), moving.scene.node_mass);
    return {steps_of(std::make_shared<BulletLawExplicit>(moving.scene), moving, steps * h, steps),
            steps_of_bullet(tetrahedra_of_bullet(moving, neo_hookean_law(moving)), moving, h, steps)};
}

constexpr int cg_iterations = 25;

/// In single precision conjugate gradients fall behind later on, before they converge. Bullet has no preconditioner.
Sides corotational_step(const MovingScene &moving, bool is_check) {
    const int iterations = is_check ? 5 : cg_iterations;
    const auto ours = std::make_shared<tests::Corotational>(moving.scene, tests::Preconditioner::none);
    return {
        steps_of(ours, moving, frame, iterations),
        steps_of_bullet(tetrahedra_of_bullet(moving, linear_law(moving),
                                             {.implicit = true, .conjugate_gradients = iterations, .tolerance = 0.0}),
                        moving, frame)};
}

constexpr int global_iterations = 10;

/// Both as their users take them, and converged for the check.
Sides implicit_spring_step(const MovingScene &moving, bool is_check) {
    const auto ours = std::make_shared<UniformMassSpring>(moving.scene);
    const auto bullet =
        springs_of_bullet(moving, ours->energy().springs(),
                          is_check ? BulletIterations{.implicit = true, .newton = 12, .tolerance = 1e-10}
                                   : BulletIterations{.implicit = true});
    return {steps_of(ours, moving, frame, is_check ? 400 : global_iterations), steps_of_bullet(bullet, moving, frame)};
}

constexpr int passes = 10;

/// Springs alone, because btSoftBody has no volumes of tetrahedra: below Poisson's ratio 1/4 neither has xpbd_springs.
/// Both are in single precision, ours on the vectors that the arena takes.
Sides position_based_step(const MovingScene &moving, bool is_check) {
    auto body = std::make_shared<core::Body>(*moving.scene.body);
    for (auto &material : body->materials)
        material.poisson_ratio = 0.2;
    auto changed = moving;
    changed.scene.body = body;
    const int iterations = is_check ? 1 : passes;
    std::shared_ptr<Simulation> ours = interactive::find_method("xpbd_springs").prepare(changed.scene);
    auto bullet = std::make_shared<BulletPositionBased>(changed.scene, iterations);
    const auto [edges, parts] = links_as_compliant(changed.scene, frame);
    append_links(*bullet->body, edges, parts);
    return {steps_of(ours, changed, frame, iterations), steps_of_bullet(bullet, changed, frame)};
}

MovingScene make_moving_scene(const std::shared_ptr<const core::Body> &body) {
    const auto still = make_scene(body);
    MovingScene moving{.scene = nodes_of(still), .start = Field(3, still.start.size()), .targets = {}};
    for (std::size_t i = 0; i < still.start.size(); ++i)
        moving.start.col(static_cast<Eigen::Index>(i)) = still.start[i];
    moving.targets = moving.start(Eigen::all, moving.scene.constrained_nodes);
    return moving;
}

/// Bullet is in single precision: on liver_healthy and liver_refined_once 1e-4 and 3e-4 were seen of forces, 4e-5 and
/// 2e-4 of implicit steps. A pass over links differs by the stretch of the links, 1 %.
std::vector<Comparison> bullet_comparisons() {
    constexpr double rounding = 1e-3, stretch = 0.02;
    return {
        {.name = "corotational_forces", .make = corotational_forces, .tolerance = rounding},
        {.name = "neo_hookean_forces", .make = neo_hookean_forces, .tolerance = rounding},
        {.name = "spring_forces", .make = spring_forces, .tolerance = rounding},
        {.name = "explicit_neo_hookean_step", .make = explicit_neo_hookean_step, .tolerance = rounding},
        {.name = "corotational_step", .iterations = cg_iterations, .make = corotational_step, .tolerance = rounding},
        {.name = "implicit_spring_step",
         .iterations = global_iterations,
         .make = implicit_spring_step,
         .tolerance = rounding},
        {.name = "position_based_step", .iterations = passes, .make = position_based_step, .tolerance = stretch}};
}

double difference(const Sides &sides) {
    for (const auto *side : {&sides.ours, &sides.bullet}) {
        side->reset();
        side->work();
    }
    const Field ours = sides.ours.result();
    return (sides.bullet.result() - ours).norm() / ours.norm();
}

constexpr int times_in_a_row = 5;

/// The work a few times from the start; implicit steps would come to rest, where there is nothing left to do.
/// @return time of all [s]
double time_of(const Side &side) {
    side.reset();
    const double start = core::processor_seconds();
    for (int i = 0; i < times_in_a_row; ++i)
        side.work();
    return core::processor_seconds() - start;
}

struct Checked {
    std::string name;
    Sides sides;
    double difference = 0.0, checked = 0.0; ///< of what is timed, and of what has converged
    std::string fault;
};

Checked check(const std::string &name, const Comparison &comparison, const std::string &body) {
    static std::optional<MovingScene> scene;
    if (!scene || scene->scene.body->name != body)
        scene = make_moving_scene(make_body(body));
    Checked checked{.name = name, .sides = comparison.make(*scene, false), .fault = {}};
    checked.difference = difference(checked.sides);
    checked.checked = difference(comparison.make(*scene, true));
    if (!(checked.checked < comparison.tolerance))
        checked.fault =
            fmt::format("results differ by {:.1e}, more than {:.1e}", checked.checked, comparison.tolerance);
    return checked;
}

/// Both by turns, so that a machine that is slow for a while is slow for both.
void time_both(benchmark::State &state, const std::string &name, const Comparison &comparison,
               const std::string &body) {
    static std::optional<Checked> last; // Google Benchmark calls several times
    if (!last || last->name != name)
        last = check(name, comparison, body);
    if (!last->fault.empty()) {
        state.SkipWithError(last->fault.c_str());
        return;
    }
    double ours = 0.0, theirs = 0.0;
    for (auto _ : state) {
        const double first = time_of(last->sides.ours), second = time_of(last->sides.bullet);
        state.SetIterationTime(first + second);
        ours += first;
        theirs += second;
    }
    const double all = static_cast<double>(state.iterations()) * times_in_a_row;
    state.counters["livermark"] = ours / all;
    state.counters["bullet"] = theirs / all;
    state.counters["bullet_over_livermark"] = theirs / ours;
    state.counters["inner_iterations"] = comparison.iterations;
    state.counters["difference"] = last->difference;
    state.counters["difference_converged"] = last->checked;
}

void register_comparisons() {
    for (const auto &body : body_names())
        if (num_refinements(body) <= 1 && body != "liver_tumours") // Bullet has one material for all
            for (const auto &comparison : bullet_comparisons()) {
                const auto name = fmt::format("bullet/{}/{}", comparison.name, body);
                benchmark::RegisterBenchmark(name.c_str(), [name, comparison, body](benchmark::State &state) {
                    time_both(state, name, comparison, body);
                })->UseManualTime();
            }
}

} // namespace
} // namespace livermark::benchmarks

int main(int argc, char **argv) {
    return livermark::benchmarks::run_program(argc, argv, livermark::benchmarks::register_comparisons);
}
