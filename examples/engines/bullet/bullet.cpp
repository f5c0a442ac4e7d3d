// Solves a problem or moves a scene of `livermark export` with Bullet, and writes what `livermark score` reads.
//
//   bullet PROBLEM.problem.h5 SOLUTION.csv [--NAME VALUE]...   at rest, with the nodal forces of the .vtu beside it
//   bullet SCENE.scene.h5 MOTION.h5 [--NAME VALUE]...          in motion
// Tetrahedra of btDeformableLinearElasticityForce (co-rotational) or btDeformableNeoHookeanForce in implicit steps. One
// step in a frame, one iteration of Newton's method and at most 300 of conjugate gradients are what Bullet takes by
// itself. Constrained nodes have zero mass: Bullet moves them with their velocity, whatever pulls. README.md has the
// command that compiles this, and the settings.
#include "examples/engines/bullet/files.hpp"
#include "examples/engines/bullet/world.hpp"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <memory>
#include <string>
#include <vector>

struct Rest {
    std::vector<double> displacement; ///< (N, 3) [m]
    int steps = 0;
    double force = 0.0; ///< total of the tools that press to a depth [N]
    bool is_at_rest = false;
};

/// Steps until a step moves no node by more than 2e-6 of the largest displacement per damping time.
bool relax(World &world, const Input &input, const Settings &settings, Rest &rest) {
    const double part = 2e-6 * std::min(1.0, settings.time_step * std::max(settings.mass_damping, 1.0));
    std::vector<btVector3> before(input.num_nodes());
    int quiet = 0;
    while (rest.steps < settings.steps) {
        const int num_press = world.ball ? settings.press_steps : 0;
        if (rest.steps < num_press)
            world.ball->press((rest.steps + 1.0) / num_press);
        for (const int i : input.held) // to where they are prescribed, in the first step
            world.body->m_nodes[i].m_v = world.body->m_nodes[i].m_vn =
                (world.points[i] + static_cast<btScalar>(settings.load_factor) * vector(input.prescribed, i) -
                 world.body->m_nodes[i].m_x) /
                static_cast<btScalar>(settings.time_step);
        for (int i = 0; i < input.num_nodes(); ++i)
            before[i] = world.body->m_nodes[i].m_x;
        world.step(settings.time_step);
        ++rest.steps;
        double motion = 0.0, peak = 0.0;
        for (int i = 0; i < input.num_nodes(); ++i) {
            const auto &x = world.body->m_nodes[i].m_x;
            motion = std::max(motion, static_cast<double>((x - before[i]).length()));
            peak = std::max(peak, static_cast<double>((x - world.points[i]).length()));
        }
        if (!std::isfinite(peak) || peak > 10.0)
            stop("the body flies apart; take a smaller --time_step, or a smaller --load_factor");
        const bool is_quiet = motion <= part * peak + 2e-8; // 2e-8 m: what single precision rounds
        quiet = is_quiet && rest.steps > num_press ? quiet + 1 : 0;
        if (quiet == 3)
            return true;
    }
    return false;
}

Rest solve(World &world, const Input &input, const Settings &settings, DeadForces &forces) {
    Rest rest;
    double press = input.press_depth > 0.0 ? 20.0 * input.press_depth : 1.0; // [N], of tissue of some kPa
    for (int guess = 0; guess < 20; ++guess) {
        forces.factor = static_cast<btScalar>(press * settings.load_factor);
        rest.is_at_rest = relax(world, input, settings, rest);
        rest.displacement.assign(input.points.size(), 0.0);
        double depth = 0.0; // sum f . u
        for (int i = 0; i < input.num_nodes(); ++i)
            for (int c = 0; c < 3; ++c) {
                auto &u = rest.displacement[3 * i + c];
                u = (static_cast<double>(world.body->m_nodes[i].m_x[c]) - world.points[i][c]) / settings.load_factor;
                depth += input.force[3 * i + c] * u;
            }
        rest.force = press;
        if (input.press_depth == 0.0 || std::abs(depth / input.press_depth - 1.0) < 1e-3)
            return rest;
        if (!(depth > 0.0))
            break;
        press *= input.press_depth / depth;
    }
    stop("no force presses to the depth of the problem");
}

/// By how much the node that is deepest in the ball is inside it [m].
double deepest(const Ball &ball, const World &world) {
    double least = 1e30;
    const btVector3 centre = vector(ball.start) + vector(ball.press);
    for (int i = 0; i < world.body->m_nodes.size(); ++i)
        least = std::min(least, static_cast<double>((world.body->m_nodes[i].m_x - centre).length()));
    return std::max(0.0, ball.radius - least);
}

/// Elastic force of the body on some of its nodes together [N].
btVector3 elastic_force(const std::vector<int> &nodes, const Input &input, World &world) {
    btDeformableLagrangianForce::TVStack forces;
    forces.resize(input.num_nodes(), btVector3(0, 0, 0));
    world.body->updateDeformation();
    world.law->addScaledExplicitForce(1.0F, forces); // elastic alone
    btVector3 sum(0, 0, 0);
    for (const int node : nodes)
        sum += forces[node];
    return sum;
}

Report rest_of(const char *path, const Input &input, const Settings &settings) {
    const std::clock_t start = std::clock();
    if (input.touch && settings.load_factor != 1.0)
        stop("a ball moves by its whole way; leave --load_factor out");
    World world(input, settings, settings.mass_damping);
    DeadForces forces(input.force);
    world.add(forces);
    Report report{.setup_seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC};
    const Rest rest = solve(world, input, settings, forces);
    write_solution(path, input, rest.displacement);
    report.solve_seconds = world.seconds();
    report.seconds_per_frame = world.seconds() / rest.steps;
    report.more =
        ", \"steps\": " + std::to_string(rest.steps) + ", \"at_rest\": " + (rest.is_at_rest ? "true" : "false");
    if (input.touch) // what the nodes that are held bear
        report.more += ", \"force\": " + std::to_string(elastic_force(input.held, input, world).length()) +
                       ", \"deepest\": " + std::to_string(deepest(*input.touch, world));
    else if (input.press_depth > 0.0)
        report.more += ", \"force\": " + std::to_string(rest.force);
    return report;
}

void keep(Motion &motion, const Input &input, const btSoftBody &body, const btVector3 &force) {
    for (int i = 0; i < input.num_nodes(); ++i)
        for (int c = 0; c < 3; ++c)
            motion.displacement.push_back(static_cast<float>(body.m_nodes[i].m_x[c] - input.points[3 * i + c]));
    for (int c = 0; c < 3; ++c)
        motion.force.push_back(force[c]);
}

Motion move(World &world, const Input &input, const Settings &settings) {
    Motion motion;
    keep(motion, input, *world.body, {0, 0, 0});
    for (int k = 1; k < input.num_records(); ++k) {
        const bool is_held = k <= input.last_record_held;
        const auto step = static_cast<btScalar>((input.time[k] - input.time[k - 1]) / settings.substeps);
        if (k == input.last_record_held + 1)
            for (const int node : input.tool)
                world.body->setMass(node, world.mass[node]);
        for (int s = 1; s <= settings.substeps; ++s) {
            for (std::size_t t = 0; is_held && t < input.tool.size(); ++t) { // to where the tool is after the step
                auto &node = world.body->m_nodes[input.tool[t]];
                const btVector3 from = vector(input.way, (k - 1) * input.tool.size() + t);
                const btVector3 to = vector(input.way, k * input.tool.size() + t);
                const btScalar part = static_cast<btScalar>(s) / static_cast<btScalar>(settings.substeps);
                node.m_v = node.m_vn = (world.points[input.tool[t]] + from.lerp(to, part) - node.m_x) / step;
            }
            world.step(step);
        }
        keep(motion, input, *world.body, is_held ? elastic_force(input.tool, input, world) : btVector3(0, 0, 0));
    }
    return motion;
}

Report motion_of(const char *path, const Input &input, const Settings &settings) {
    const std::clock_t start = std::clock();
    World world(input, settings, input.mass_damping);
    Report report{.setup_seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC};
    const Motion motion = move(world, input, settings);
    report.solve_seconds = world.seconds();
    report.seconds_per_frame = world.seconds() / (input.num_records() - 1);
    write_motion(path, input, motion, report.seconds_per_frame);
    return report;
}

int main(int argc, char **argv) {
    if (argc < 3)
        stop("usage: bullet PROBLEM.problem.h5 SOLUTION.csv, or bullet SCENE.scene.h5 MOTION.h5, then --NAME VALUE");
    Settings settings = read_settings(argc, argv);
    const Input input = read_input(argv[1]);
    if (settings.time_step == 0.0)
        settings.time_step = input.touch ? 0.02 : 1.0;
    const bool is_rest = !input.force.empty();
    print(btGetVersion(), is_rest ? rest_of(argv[2], input, settings) : motion_of(argv[2], input, settings), settings,
          is_rest);
}
