// Solves a problem or moves a scene of `livermark export` with Bullet, and writes what `livermark score` reads.
//
//   bullet PROBLEM.problem.h5 SOLUTION.csv [--NAME VALUE]...   at rest, with the nodal forces of the .vtu beside it
//   bullet SCENE.scene.h5 MOTION.h5 [--NAME VALUE]...          in motion
// Tetrahedra of btDeformableLinearElasticityForce (co-rotational) or btDeformableNeoHookeanForce in implicit steps. One
// step in a frame, one iteration of Newton's method and at most 300 of conjugate gradients are what Bullet takes by
// itself. Constrained nodes have zero mass: Bullet moves them with their velocity, whatever pulls. README.md has the
// command that compiles this, and the settings.
#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletSoftBody/btDeformableBodySolver.h>
#include <BulletSoftBody/btDeformableLinearElasticityForce.h>
#include <BulletSoftBody/btDeformableMultiBodyConstraintSolver.h>
#include <BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h>
#include <BulletSoftBody/btDeformableNeoHookeanForce.h>
#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <hdf5.h>
#include <hdf5_hl.h>
#include <map>
#include <memory>
#include <string>
#include <vector>

[[noreturn]] void stop(const std::string &what) {
    std::fprintf(stderr, "bullet: %s\n", what.c_str());
    std::exit(2);
}

/// Choices of the command line.
struct Settings {
    std::string law = "corotational"; ///< or neo_hookean
    int iterations = 300;             ///< at most, of conjugate gradients in a step
    int newton = 1;                   ///< iterations of Newton's method in a step
    int substeps = 1;                 ///< in a frame; in motion
    double stiffness_damping = 0.0;   ///< [s]
    double mass_damping = 20.0;       ///< [1/s]; at rest. A scene has its own
    double time_step = 1.0;           ///< [s]; at rest. So long that the mass plays no part
    int steps = 500;                  ///< at most; at rest
    double load_factor = 1.0;         ///< loads are multiplied, and displacements divided by it; at rest
};

double number(const std::string &name, const char *text) {
    char *end = nullptr;
    const double value = std::strtod(text, &end);
    if (end == text || *end != '\0' || !std::isfinite(value) || value < 0.0)
        stop("--" + name + " " + text + " is no number from 0; give one");
    return value;
}

int count(const std::string &name, const char *text) {
    const double value = number(name, text);
    if (value < 1.0 || value > 1e9 || value != std::floor(value))
        stop("--" + name + " " + text + " is no whole number from 1; give one");
    return static_cast<int>(value);
}

Settings read_settings(int argc, char **argv) {
    Settings settings;
    const std::map<std::string, int *> counts{{"iterations", &settings.iterations},
                                              {"newton", &settings.newton},
                                              {"substeps", &settings.substeps},
                                              {"steps", &settings.steps}};
    const std::map<std::string, double *> numbers{{"stiffness_damping", &settings.stiffness_damping},
                                                  {"mass_damping", &settings.mass_damping},
                                                  {"time_step", &settings.time_step},
                                                  {"load_factor", &settings.load_factor}};
    for (int i = 3; i < argc; i += 2) {
        const std::string word = argv[i], name = word.substr(std::min<std::size_t>(2, word.size()));
        if (word.substr(0, 2) != "--" || i + 1 == argc)
            stop("options are --NAME VALUE; see README.md");
        if (name == "law")
            settings.law = argv[i + 1];
        else if (counts.contains(name))
            *counts.at(name) = count(name, argv[i + 1]);
        else if (numbers.contains(name))
            *numbers.at(name) = number(name, argv[i + 1]);
        else
            stop("there is no setting --" + name + "; see README.md");
    }
    if ((settings.law != "corotational" && settings.law != "neo_hookean") || settings.time_step == 0.0 ||
        settings.load_factor == 0.0)
        stop("--law is corotational or neo_hookean, and --time_step and --load_factor are above 0");
    return settings;
}

/// A body, and what moves it: see "The problem" and "Tool scenes" in results/schema.md.
struct Input {
    std::vector<double> points, density, young_modulus, poisson_ratio;
    std::vector<int> tetrahedra, held{}; ///< held: constrained nodes
    // In motion:
    std::vector<double> time{}, way{}; ///< (K) [s], (K, T, 3) [m]
    std::vector<int> tool{};
    double mass_damping = 0.0;
    int last_record_held = 0;
    // At rest:
    std::vector<double> prescribed{}, force{}; ///< (N, 3) [m], [N]
    double press_depth = 0.0;                  ///< [m]; the forces are those of one newton then

    int num_nodes() const { return static_cast<int>(points.size() / 3); }
    int num_records() const { return static_cast<int>(time.size()); }
};

template <class T> std::vector<T> read(hid_t file, const std::string &path, hid_t type) {
    int rank = 0;
    hsize_t shape[3]{1, 1, 1};
    if (H5LTget_dataset_ndims(file, path.c_str(), &rank) < 0 ||
        H5LTget_dataset_info(file, path.c_str(), shape, nullptr, nullptr) < 0)
        stop("this is no problem and no scene of livermark export");
    std::vector<T> values(shape[0] * shape[1] * shape[2]);
    H5LTread_dataset(file, path.c_str(), type, values.data());
    return values;
}

/// Values of an array at the nodes in a .vtu of livermark export, which is ASCII.
std::vector<double> read_vtu(const std::string &path, const std::string &name, std::size_t size) {
    std::ifstream file(path);
    const std::string quoted = '"' + name + '"';
    std::string line;
    while (std::getline(file, line) && line.find(quoted) == std::string::npos) {
    }
    std::vector<double> values(size);
    for (double &value : values)
        file >> value;
    if (!file)
        stop(path + " has no " + name + "; export the problem with the format vtu");
    return values;
}

void read_rest(Input &input, hid_t file, const std::string &problem) {
    for (const char *part : {"/load_case/touch", "/load_case/follows", "/load_case/slow_history"})
        if (H5Lexists(file, part, H5P_DEFAULT) > 0)
            stop(std::string("the problem has ") + part + ", which nodal forces cannot say; choose another load case");
    if (H5Aexists_by_name(file, "/load_case", "press_depth", H5P_DEFAULT) > 0)
        H5LTget_attribute_double(file, "/load_case", "press_depth", &input.press_depth);
    const auto vtu = problem.substr(0, problem.rfind(".problem.h5")) + ".vtu";
    input.prescribed = read_vtu(vtu, "prescribed_displacement", input.points.size());
    input.force = read_vtu(vtu, "nodal_force", input.points.size());
    const auto is_prescribed = read_vtu(vtu, "is_prescribed", input.points.size());
    for (int i = 0; i < input.num_nodes(); ++i) {
        const double components = is_prescribed[3 * i] + is_prescribed[3 * i + 1] + is_prescribed[3 * i + 2];
        if (components == 3.0)
            input.held.push_back(i);
        else if (components > 0.0)
            stop("a node is constrained in some components alone, and zero mass constrains all three");
    }
}

Input read_input(const std::string &path) {
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    if (file < 0)
        stop("the problem or scene cannot be read");
    const bool is_rest = H5Lexists(file, "/mesh", H5P_DEFAULT) > 0;
    const std::string mesh = is_rest ? "/mesh" : "";
    Input input{.points = read<double>(file, mesh + "/points", H5T_NATIVE_DOUBLE),
                .density = read<double>(file, "/materials/density", H5T_NATIVE_DOUBLE),
                .young_modulus = read<double>(file, "/materials/young_modulus", H5T_NATIVE_DOUBLE),
                .poisson_ratio = read<double>(file, "/materials/poisson_ratio", H5T_NATIVE_DOUBLE),
                .tetrahedra = read<int>(file, mesh + "/tetrahedra", H5T_NATIVE_INT)};
    if (input.density.size() != 1)
        stop("the body has several materials, and a law of Bullet has one for all");
    if (is_rest) {
        read_rest(input, file, path);
    } else {
        input.held = read<int>(file, "/held", H5T_NATIVE_INT);
        input.tool = read<int>(file, "/tool/nodes", H5T_NATIVE_INT);
        input.time = read<double>(file, "/tool/time", H5T_NATIVE_DOUBLE);
        input.way = read<double>(file, "/tool/displacement", H5T_NATIVE_DOUBLE);
        H5LTget_attribute_double(file, "/tool", "mass_damping", &input.mass_damping);
        H5LTget_attribute_int(file, "/tool", "last_record_held", &input.last_record_held);
    }
    H5Fclose(file);
    return input;
}

btVector3 vector(const std::vector<double> &values, std::size_t i) {
    return {static_cast<btScalar>(values[3 * i]), static_cast<btScalar>(values[3 * i + 1]),
            static_cast<btScalar>(values[3 * i + 2])};
}

/// A quarter of each tetrahedron at each of its nodes.
std::vector<btScalar> node_masses(const Input &input) {
    std::vector<btScalar> mass(input.num_nodes(), 0.0F);
    for (std::size_t t = 0; t < input.tetrahedra.size(); t += 4) {
        const int *nodes = &input.tetrahedra[t];
        const btVector3 origin = vector(input.points, nodes[0]);
        const btScalar volume = (vector(input.points, nodes[1]) - origin)
                                    .cross(vector(input.points, nodes[2]) - origin)
                                    .dot(vector(input.points, nodes[3]) - origin) /
                                6.0F;
        for (int corner = 0; corner < 4; ++corner)
            mass[nodes[corner]] += static_cast<btScalar>(input.density[0]) * volume / 4.0F;
    }
    return mass;
}

/// Bullet's solver, whose numbers of iterations its programs can reach in no other way.
class Solver : public btDeformableBodySolver {
  public:
    explicit Solver(const Settings &settings) {
        m_maxNewtonIterations = settings.newton;
        m_newtonTolerance = settings.newton > 1 ? 0.0F : m_newtonTolerance;
        m_cg.m_maxIterations = settings.iterations;
    }
};

/// Forces at nodes that do not depend on the displacement. Bullet has none such but gravity.
class DeadForces : public btDeformableLagrangianForce {
  public:
    explicit DeadForces(const std::vector<double> &forces) : forces_(forces) {}
    void addScaledForces(btScalar scale, TVStack &force) override {
        for (int i = 0; i < force.size(); ++i)
            force[i] += scale * factor * vector(forces_, i);
    }
    void addScaledExplicitForce(btScalar scale, TVStack &force) override { addScaledForces(scale, force); }
    void addScaledDampingForce(btScalar, TVStack &) override {}
    void addScaledElasticForceDifferential(btScalar, const TVStack &, TVStack &) override {}
    void addScaledDampingForceDifferential(btScalar, const TVStack &, TVStack &) override {}
    void buildDampingForceDifferentialDiagonal(btScalar, TVStack &) override {}
    btDeformableLagrangianForceType getForceType() override { return BT_MOUSE_PICKING_FORCE; } // any but gravity

    btScalar factor = 1.0F;

  private:
    const std::vector<double> &forces_;
};

/// The law with the Lame parameters of the material. Bullet's neo-Hookean energy has a logarithm that softens it: it
/// needs 4/3 mu and lambda + 5/6 mu (docs/studies/bullet.md).
std::unique_ptr<btDeformableLagrangianForce> make_law(const Input &input, const Settings &settings,
                                                      double mass_damping) {
    const double young = input.young_modulus[0], poisson = input.poisson_ratio[0];
    const double mu = young / (2.0 + 2.0 * poisson), lambda = 2.0 * mu * poisson / (1.0 - 2.0 * poisson);
    if (settings.law == "neo_hookean")
        return std::make_unique<btDeformableNeoHookeanForce>(static_cast<btScalar>(4.0 / 3.0 * mu),
                                                             static_cast<btScalar>(lambda + 5.0 / 6.0 * mu),
                                                             static_cast<btScalar>(settings.stiffness_damping));
    return std::make_unique<btDeformableLinearElasticityForce>(static_cast<btScalar>(mu), static_cast<btScalar>(lambda),
                                                               static_cast<btScalar>(mass_damping),
                                                               static_cast<btScalar>(settings.stiffness_damping));
}

/// A world with the body alone. The tool has hold of its nodes, so nobody looks for contact.
class World {
  public:
    World(const Input &input, const Settings &settings, double mass_damping)
        : mass(node_masses(input)), law(make_law(input, settings, mass_damping)), solver_(settings),
          damping_(settings.law == "neo_hookean" ? mass_damping : 0.0) {
        constraints_.setDeformableSolver(&solver_);
        world_.setGravity({0, 0, 0});
        world_.setImplicit(true);
        world_.setUseProjection(true); // without it implicit steps have no preconditioner to go on with
        for (int i = 0; i < input.num_nodes(); ++i)
            points.push_back(vector(input.points, i));
        body = std::make_unique<btSoftBody>(&world_.getWorldInfo(), input.num_nodes(), points.data(), mass.data());
        for (std::size_t t = 0; t < input.tetrahedra.size(); t += 4)
            body->appendTetra(input.tetrahedra[t], input.tetrahedra[t + 1], input.tetrahedra[t + 2],
                              input.tetrahedra[t + 3]);
        body->m_tetraScratches.resize(body->m_tetras.size());
        body->m_tetraScratchesTn.resize(body->m_tetras.size());
        body->initializeDmInverse();
        body->m_cfg.collisions = 0;
        body->setActivationState(DISABLE_DEACTIVATION);
        for (const auto *nodes : {&input.held, &input.tool})
            for (const int node : *nodes)
                body->setMass(node, 0.0F);
        world_.addSoftBody(body.get());
        world_.addForce(body.get(), law.get());
    }
    ~World() { world_.removeSoftBody(body.get()); }
    World(const World &) = delete;
    World &operator=(const World &) = delete;

    void add(btDeformableLagrangianForce &force) { world_.addForce(body.get(), &force); }
    void step(double time_step) {
        const std::clock_t start = std::clock();
        world_.stepSimulation(static_cast<btScalar>(time_step), 0);
        for (int i = 0; damping_ > 0.0 && i < body->m_nodes.size(); ++i)
            body->m_nodes[i].m_v *= static_cast<btScalar>(std::exp(-damping_ * time_step));
        ticks_ += std::clock() - start;
    }
    double seconds() const { return static_cast<double>(ticks_) / CLOCKS_PER_SEC; } ///< of all steps

    std::vector<btScalar> mass;
    std::vector<btVector3> points;
    std::unique_ptr<btSoftBody> body;
    std::unique_ptr<btDeformableLagrangianForce> law;

  private:
    btSoftBodyRigidBodyCollisionConfiguration configuration_;
    btCollisionDispatcher dispatcher_{&configuration_};
    btDbvtBroadphase broadphase_;
    Solver solver_;
    btDeformableMultiBodyConstraintSolver constraints_;
    btDeformableMultiBodyDynamicsWorld world_{&dispatcher_, &broadphase_, &constraints_, &configuration_, &solver_};
    double damping_; // of the mass [1/s], which the neo-Hookean law does not have
    std::clock_t ticks_ = 0;
};

/// Report of an engine on its own run: the last line of its output.
struct Report {
    double seconds_per_frame = 0.0, setup_seconds = 0.0, solve_seconds = 0.0;
    std::string more{}; ///< further entries
};

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
        quiet = motion <= part * peak + 2e-8 ? quiet + 1 : 0; // 2e-8 m: what single precision rounds
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

Report write_rest(const char *path, const Input &input, const Settings &settings) {
    const std::clock_t start = std::clock();
    World world(input, settings, settings.mass_damping);
    DeadForces forces(input.force);
    world.add(forces);
    Report report{.setup_seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC};
    const Rest rest = solve(world, input, settings, forces);
    std::FILE *file = std::fopen(path, "w");
    if (!file)
        stop("the solution cannot be written");
    std::fprintf(file, "x,y,z,ux,uy,uz\n");
    for (int i = 0; i < input.num_nodes(); ++i) {
        const double *x = &input.points[3 * i], *u = &rest.displacement[3 * i];
        std::fprintf(file, "%.17g,%.17g,%.17g,%.9g,%.9g,%.9g\n", x[0], x[1], x[2], u[0], u[1], u[2]);
    }
    std::fclose(file);
    report.solve_seconds = world.seconds();
    report.seconds_per_frame = world.seconds() / rest.steps;
    report.more =
        ", \"steps\": " + std::to_string(rest.steps) + ", \"at_rest\": " + (rest.is_at_rest ? "true" : "false");
    if (input.press_depth > 0.0)
        report.more += ", \"force\": " + std::to_string(rest.force);
    return report;
}

/// Displacements (K, N, 3) and forces (K, 3) of the body on the tool.
struct Motion {
    std::vector<float> displacement;
    std::vector<double> force;
};

void keep(Motion &motion, const Input &input, const btSoftBody &body, const btVector3 &force) {
    for (int i = 0; i < input.num_nodes(); ++i)
        for (int c = 0; c < 3; ++c)
            motion.displacement.push_back(static_cast<float>(body.m_nodes[i].m_x[c] - input.points[3 * i + c]));
    for (int c = 0; c < 3; ++c)
        motion.force.push_back(force[c]);
}

btVector3 tool_force(const Input &input, World &world) {
    btDeformableLagrangianForce::TVStack forces;
    forces.resize(input.num_nodes(), btVector3(0, 0, 0));
    world.body->updateDeformation();
    world.law->addScaledExplicitForce(1.0F, forces); // elastic alone
    btVector3 sum(0, 0, 0);
    for (const int node : input.tool)
        sum += forces[node];
    return sum;
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
        keep(motion, input, *world.body, is_held ? tool_force(input, world) : btVector3(0, 0, 0));
    }
    return motion;
}

Report write_motion(const char *path, const Input &input, const Settings &settings) {
    const std::clock_t start = std::clock();
    World world(input, settings, input.mass_damping);
    Report report{.setup_seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC};
    const Motion motion = move(world, input, settings);
    report.solve_seconds = world.seconds();
    report.seconds_per_frame = world.seconds() / (input.num_records() - 1);
    const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    H5Pset_libver_bounds(access, H5F_LIBVER_LATEST, H5F_LIBVER_LATEST);
    const hid_t file = H5Fcreate(path, H5F_ACC_TRUNC, H5P_DEFAULT, access);
    if (file < 0)
        stop("the motion cannot be written");
    const auto num_records = static_cast<hsize_t>(input.num_records());
    const hsize_t fields[3]{num_records, static_cast<hsize_t>(input.num_nodes()), 3}, forces[2]{num_records, 3};
    H5LTmake_dataset_float(file, "/displacement", 3, fields, motion.displacement.data());
    H5LTmake_dataset_double(file, "/force", 2, forces, motion.force.data());
    H5LTset_attribute_double(file, "/", "seconds_per_frame", &report.seconds_per_frame, 1);
    H5Fclose(file);
    H5Pclose(access);
    return report;
}

/// Largest resident memory [bytes]. That of getrusage includes the program that started this one.
long peak_memory() {
    std::ifstream file("/proc/self/status");
    long kibibytes = 0;
    for (std::string word; file >> word;)
        if (word == "VmHWM:")
            file >> kibibytes;
    return 1024 * kibibytes;
}

void print(const Report &report, const Settings &settings, bool is_rest) {
    std::printf(
        "{\"engine\": \"bullet\", \"version\": \"%d.%02d\", \"settings\": {\"law\": \"%s\", \"iterations\": %d, "
        "\"newton\": %d, \"stiffness_damping\": %g, ",
        btGetVersion() / 100, btGetVersion() % 100, settings.law.c_str(), settings.iterations, settings.newton,
        settings.stiffness_damping);
    if (is_rest)
        std::printf("\"mass_damping\": %g, \"time_step\": %g, \"load_factor\": %g}", settings.mass_damping,
                    settings.time_step, settings.load_factor);
    else
        std::printf("\"substeps\": %d}", settings.substeps);
    std::printf(", \"seconds_per_frame\": %g, \"setup_seconds\": %g, \"solve_seconds\": %g, \"memory_bytes\": %ld%s}\n",
                report.seconds_per_frame, report.setup_seconds, report.solve_seconds, peak_memory(),
                report.more.c_str());
}

int main(int argc, char **argv) {
    if (argc < 3)
        stop("usage: bullet PROBLEM.problem.h5 SOLUTION.csv, or bullet SCENE.scene.h5 MOTION.h5, then --NAME VALUE");
    const Settings settings = read_settings(argc, argv);
    const Input input = read_input(argv[1]);
    const bool is_rest = !input.force.empty();
    print(is_rest ? write_rest(argv[2], input, settings) : write_motion(argv[2], input, settings), settings, is_rest);
}
