#include "results/hdf5/files/reference_file.hpp"

#include <array>
#include <fmt/format.h>

#include "results/hdf5/file_parts.hpp"
#include "results/hdf5/io/hdf5_io.hpp"
#include "results/hdf5/io/schema.hpp"
#include "results/hdf5/solution_group.hpp"
#include "support/fnv_hash.hpp"
#include "support/whole_file.hpp"

namespace livermark::results {

namespace {

/// Of numbers that count with nine digits.
class Hash : public support::FnvHash {
  public:
    using FnvHash::add;
    void add(double number) { add(fmt::format("{:.8e}", number == 0.0 ? 0.0 : number)); }
    void add(const core::Vector3 &vector) {
        for (const double component : vector)
            add(component);
    }
    template <class Numbers> void add_integers(const Numbers &numbers) {
        for (const auto number : numbers)
            add(fmt::format("{}", static_cast<int>(number)));
    }
};

} // namespace

std::string fingerprint(const core::Problem &problem, const std::string &model) {
    const auto &mesh = problem.body->mesh;
    const auto &load_case = problem.load_case;
    Hash hash;
    hash.add(model);
    for (const auto &point : mesh.points)
        hash.add(point);
    for (const auto &nodes : mesh.tetrahedra)
        hash.add_integers(nodes);
    for (const auto &nodes : mesh.boundary_triangles)
        hash.add_integers(nodes);
    hash.add_integers(mesh.region);
    for (const auto &material : problem.body->materials) {
        hash.add(material.density);
        hash.add(material.young_modulus);
        hash.add(material.poisson_ratio);
    }
    hash.add(core::to_string(load_case.regime));
    hash.add_integers(load_case.condition);
    hash.add_integers(load_case.constraint);
    hash.add_integers(load_case.follows);
    for (const auto &value : load_case.value)
        hash.add(value);
    for (const double factor : load_case.node_factor)
        hash.add(factor);
    for (const auto &shift : load_case.node_shift)
        hash.add(shift);
    hash.add_integers(load_case.round_load);
    for (const auto &load : load_case.round_loads) {
        hash.add(load.middle);
        hash.add(load.radius);
    }
    if (load_case.press_depth != 0.0) // others keep the name that they had before there was one
        hash.add(load_case.press_depth);
    if (const auto &ball = load_case.touching) {
        hash.add_integers(std::array{ball->constraint});
        for (const auto &vector : {ball->start, ball->press, ball->slide})
            hash.add(vector);
        for (const double number : {ball->radius, ball->friction})
            hash.add(number);
    }
    hash.add(load_case.acceleration);
    for (const double fraction : load_case.path)
        hash.add(fraction);
    for (const auto &name : load_case.constraint_names)
        hash.add(name);
    if (const auto &release = load_case.release) {
        hash.add_integers(std::array{release->num_steps});
        for (const double number : {release->output_interval, release->damping.alpha, release->damping.beta})
            hash.add(number);
        for (const auto &probe : release->probes)
            hash.add_integers(std::array{probe.node});
    }
    if (const auto &tool = load_case.tool) {
        hash.add_integers(std::array{tool->constraint, tool->num_frames});
        for (const double number : {tool->press_until, tool->slide_from, tool->slide_until, tool->release_at,
                                    tool->frame_interval, tool->mass_damping})
            hash.add(number);
        hash.add(tool->slide);
    }
    if (const auto &history = load_case.slow_history) {
        for (const auto *numbers :
             {&history->relaxation.moduli, &history->relaxation.times, &history->times, &history->factors})
            for (const double number : *numbers)
                hash.add(number);
    }
    return fmt::format("{:016x}", hash.value());
}

std::filesystem::path reference_path(const std::filesystem::path &folder, const core::Problem &problem,
                                     const std::string &model) {
    return folder / problem.body->name /
           fmt::format("{}.{}.{}.h5", problem.load_case.name, model, fingerprint(problem, model));
}

void write_reference(const std::filesystem::path &path, const core::Solution &solution, const core::Problem &problem,
                     const std::string &model, const Provenance &provenance) {
    hdf5::OutputFile file;
    hdf5::write_provenance(file, provenance);
    file.text("/", "body", problem.body->name);
    file.text("/", "load_case", problem.load_case.name);
    file.text("/", "model", model);
    file.text("/", "fingerprint", fingerprint(problem, model));
    file.group("/solutions");
    auto without_frames = solution; // they would be nearly all of the file
    if (without_frames.history)
        without_frames.history->frames.clear();
    write_solution_group(file, only_solution, without_frames, problem.load_case);
    support::write_whole(path, file.image());
}

std::optional<core::Solution> read_reference(const std::filesystem::path &path, const core::Problem &problem,
                                             const std::string &model) {
    std::error_code nobody_cares;
    if (!std::filesystem::exists(path, nobody_cares))
        return std::nullopt;
    const hdf5::InputFile file(path);
    if (!file.has_attribute("/", "fingerprint") || file.text("/", "fingerprint") != fingerprint(problem, model))
        return std::nullopt;
    auto solution = read_solution_group(file, only_solution, problem);
    solution.solver = fmt::format("stored since {} (commit {}): {}", file.text("/", "created"),
                                  file.text("/", "git_commit"), solution.solver);
    return solution;
}

} // namespace livermark::results
