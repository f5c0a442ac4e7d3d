// The command line and the report of the adapter of Bullet, and the files that it exchanges with Livermark: problems
// and scenes of `livermark export`, and what `livermark score` reads. The layout is in results/schema.md, "The problem"
// and "Tool scenes". All is in SI units.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <hdf5.h>
#include <hdf5_hl.h>
#include <map>
#include <optional>
#include <string>
#include <vector>

[[noreturn]] inline void stop(const std::string &what) {
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
    double time_step = 0.0;           ///< [s]; at rest. 0: 0.02 under a ball, else 1, where the mass plays no part
    int steps = 500;                  ///< at most; at rest
    double load_factor = 1.0;         ///< loads are multiplied, and displacements divided by it; at rest
    int press_steps = 30;             ///< in which a ball moves in; at rest
};

inline double number(const std::string &name, const char *text) {
    char *end = nullptr;
    const double value = std::strtod(text, &end);
    if (end == text || *end != '\0' || !std::isfinite(value) || value < 0.0)
        stop("--" + name + " " + text + " is no number from 0; give one");
    return value;
}

inline int count(const std::string &name, const char *text) {
    const double value = number(name, text);
    if (value < 1.0 || value > 1e9 || value != std::floor(value))
        stop("--" + name + " " + text + " is no whole number from 1; give one");
    return static_cast<int>(value);
}

inline Settings read_settings(int argc, char **argv) {
    Settings settings;
    const std::map<std::string, int *> counts{{"iterations", &settings.iterations},
                                              {"newton", &settings.newton},
                                              {"substeps", &settings.substeps},
                                              {"steps", &settings.steps},
                                              {"press_steps", &settings.press_steps}};
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
    if ((settings.law != "corotational" && settings.law != "neo_hookean") || settings.load_factor == 0.0)
        stop("--law is corotational or neo_hookean, and --load_factor is above 0");
    return settings;
}

/// A rigid ball that touches without friction.
struct Ball {
    double radius = 0.0; ///< [m]
    std::array<double, 3> start{},
        press{}; ///< centre where it just touches the body at rest, and by which it moves [m]
};

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
    std::optional<Ball> touch{};
    std::vector<int> order{}; ///< number in the problem of each node; empty: the same

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
inline std::vector<double> read_vtu(const std::string &path, const std::string &name, std::size_t size) {
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

/// The ball of a problem, or nothing where no tool touches. Refuses tools of another kind.
inline std::optional<Ball> read_ball(hid_t file, const std::string &problem) {
    const auto has = [&](const char *path) { return H5Lexists(file, path, H5P_DEFAULT) > 0; };
    const char *touch = "/load_case/touch";
    if (!has(touch))
        return std::nullopt;
    const auto way = read<double>(file, "/load_case/touch/way", H5T_NATIVE_DOUBLE);
    double friction = 0.0;
    Ball ball{.start = {way[0], way[1], way[2]}, .press = {way[3], way[4], way[5]}};
    H5LTget_attribute_double(file, touch, "radius", &ball.radius);
    H5LTget_attribute_double(file, touch, "friction", &friction);
    const char *other = H5Aexists_by_name(file, touch, "face", H5P_DEFAULT) > 0 ? "a plate"
                        : has("/load_case/touch/between")                       ? "two jaws"
                        : friction != 0.0                                       ? "a tool with friction"
                        : way[6] != 0.0 || way[7] != 0.0 || way[8] != 0.0       ? "a tool that slides"
                                                                                : nullptr;
    if (other)
        stop(problem + " has " + other +
             ", and adapters know a ball that presses without friction; choose another load case");
    return ball;
}

/// Puts constrained nodes last. Where Bullet guesses which nodes leave a tool, in btDeformableBackwardEulerObjective::
/// applyForce, it counts free nodes alone, so nodes behind a constrained one get forces of others.
inline void put_held_last(Input &input) {
    std::vector<bool> is_held(input.num_nodes(), false);
    for (const int node : input.held)
        is_held[node] = true;
    for (int i = 0; i < input.num_nodes(); ++i)
        input.order.push_back(i);
    std::stable_partition(input.order.begin(), input.order.end(), [&](int i) { return !is_held[i]; });
    std::vector<int> place(input.order.size());
    for (int i = 0; i < input.num_nodes(); ++i)
        place[input.order[i]] = i;
    for (auto *nodes : {&input.tetrahedra, &input.held})
        for (int &node : *nodes)
            node = place[node];
    for (auto *field : {&input.points, &input.prescribed, &input.force}) {
        const auto old = *field;
        for (std::size_t i = 0; i < input.order.size(); ++i)
            std::copy_n(&old[3 * input.order[i]], 3, &(*field)[3 * i]);
    }
}

inline void read_rest(Input &input, hid_t file, const std::string &problem) {
    for (const char *part : {"/load_case/follows", "/load_case/slow_history", "/load_case/foundation", "/capsule",
                             "/vessels", "/mesh/modulus_factor"})
        if (H5Lexists(file, part, H5P_DEFAULT) > 0)
            stop(std::string("the problem has ") + part + ", which nodal forces cannot say; choose another load case");
    if (H5Aexists_by_name(file, "/load_case", "press_depth", H5P_DEFAULT) > 0)
        H5LTget_attribute_double(file, "/load_case", "press_depth", &input.press_depth);
    input.touch = read_ball(file, problem);
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
    if (input.touch)
        put_held_last(input);
}

inline Input read_input(const std::string &path) {
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

/// CSV of `livermark score`: x, y, z and ux, uy, uz of each node [m].
inline void write_solution(const char *path, const Input &input, const std::vector<double> &displacement) {
    std::FILE *file = std::fopen(path, "w");
    if (!file)
        stop("the solution cannot be written");
    std::vector<int> place(input.num_nodes()); // in Bullet of each node of the problem
    for (int i = 0; i < input.num_nodes(); ++i)
        place[input.order.empty() ? i : input.order[i]] = i;
    std::fprintf(file, "x,y,z,ux,uy,uz\n");
    for (const int i : place) {
        const double *x = &input.points[3 * i], *u = &displacement[3 * i];
        std::fprintf(file, "%.17g,%.17g,%.17g,%.9g,%.9g,%.9g\n", x[0], x[1], x[2], u[0], u[1], u[2]);
    }
    std::fclose(file);
}

/// Displacements (K, N, 3) and forces (K, 3) of the body on the tool.
struct Motion {
    std::vector<float> displacement;
    std::vector<double> force;
};

/// HDF5 of `livermark score`.
inline void write_motion(const char *path, const Input &input, const Motion &motion, double seconds_per_frame) {
    const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    H5Pset_libver_bounds(access, H5F_LIBVER_LATEST, H5F_LIBVER_LATEST);
    const hid_t file = H5Fcreate(path, H5F_ACC_TRUNC, H5P_DEFAULT, access);
    if (file < 0)
        stop("the motion cannot be written");
    const auto num_records = static_cast<hsize_t>(input.num_records());
    const hsize_t fields[3]{num_records, static_cast<hsize_t>(input.num_nodes()), 3}, forces[2]{num_records, 3};
    H5LTmake_dataset_float(file, "/displacement", 3, fields, motion.displacement.data());
    H5LTmake_dataset_double(file, "/force", 2, forces, motion.force.data());
    H5LTset_attribute_double(file, "/", "seconds_per_frame", &seconds_per_frame, 1);
    H5Fclose(file);
    H5Pclose(access);
}

/// Report of an engine on its own run: the last line of its output.
struct Report {
    double seconds_per_frame = 0.0, setup_seconds = 0.0, solve_seconds = 0.0;
    std::string more{}; ///< further entries
};

/// Largest resident memory [bytes]. That of getrusage includes the program that started this one.
inline long peak_memory() {
    std::ifstream file("/proc/self/status");
    long kibibytes = 0;
    for (std::string word; file >> word;)
        if (word == "VmHWM:")
            file >> kibibytes;
    return 1024 * kibibytes;
}

inline void print(int version, const Report &report, const Settings &settings, bool is_rest) {
    std::printf(
        "{\"engine\": \"bullet\", \"version\": \"%d.%02d\", \"settings\": {\"law\": \"%s\", \"iterations\": %d, "
        "\"newton\": %d, \"stiffness_damping\": %g, ",
        version / 100, version % 100, settings.law.c_str(), settings.iterations, settings.newton,
        settings.stiffness_damping);
    if (is_rest)
        std::printf("\"mass_damping\": %g, \"time_step\": %g, \"load_factor\": %g, \"press_steps\": %d}",
                    settings.mass_damping, settings.time_step, settings.load_factor, settings.press_steps);
    else
        std::printf("\"substeps\": %d}", settings.substeps);
    std::printf(", \"seconds_per_frame\": %g, \"setup_seconds\": %g, \"solve_seconds\": %g, \"memory_bytes\": %ld%s}\n",
                report.seconds_per_frame, report.setup_seconds, report.solve_seconds, peak_memory(),
                report.more.c_str());
}
