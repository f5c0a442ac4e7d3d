#include "results/hdf5/references.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <functional>
#include <limits>
#include <span>
#include <string_view>
#include <type_traits>

#include "core/support/files.hpp"
#include "results/hdf5/hdf5_io.hpp"
#include "results/hdf5/record_file.hpp"
#include "results/hdf5/solution_group.hpp"

namespace livermark::results {

namespace {

/// Hash of numbers that count with nine digits.
class RoundedHash : public support::FnvHash {
  public:
    template <class Value> void add_all(const Value &value) {
        if constexpr (std::is_floating_point_v<Value>)
            add(fmt::format("{:.8e}", value == 0.0 ? 0.0 : value));
        else if constexpr (std::is_integral_v<Value> || std::is_enum_v<Value>)
            add(fmt::format("{}", static_cast<int>(value)));
        else
            for (const auto &part : value)
                add_all(part);
    }
};

/// Hash of every bit. The library's hash takes eight bytes at a time, and meshes are large.
class ExactHash : public support::FnvHash {
  public:
    template <class Values> void add_all(const Values &values) {
        const auto bytes = std::as_bytes(std::span(values));
        const std::string_view letters(reinterpret_cast<const char *>(bytes.data()), bytes.size());
        add(fmt::format("{:x}", std::hash<std::string_view>()(letters)));
    }
};

template <class Hash> void add_events(Hash &hash, const core::LoadCase &load_case, bool in_time) {
    core::for_each_event(load_case, [&](const auto &event) {
        if (event.in_time == in_time)
            event.add_to(hash);
    });
}

/// The one list of what a solution depends on beside the model. Its order is in the names of stored references.
template <class Hash> void add_problem(Hash &hash, const core::Problem &problem) {
    const auto &mesh = problem.body->mesh;
    const auto &load_case = problem.load_case;
    const auto facets = facet_arrays(load_case);
    hash.add_all(mesh.points);
    hash.add_all(mesh.tetrahedra);
    hash.add_all(mesh.boundary_triangles);
    hash.add_all(mesh.region);
    for (const auto &material : problem.body->materials) {
        hash.add_all(std::array{material.density, material.young_modulus, material.poisson_ratio});
        for (const auto &[law, constants] : material.law_constants) {
            hash.add(law);
            hash.add_all(constants);
        }
    }
    if (const auto &capsule = problem.body->capsule) // others keep the name that they had before there was one
        hash.add_all(std::array{capsule->thickness, capsule->young_modulus});
    if (const auto &vessels = problem.body->vessels) {
        hash.add_all(vessels->points);
        hash.add_all(vessels->radius);
        hash.add_all(vessels->segments);
        hash.add_all(std::array{vessels->wall_ratio, vessels->wall_modulus});
    }
    hash.add_all(problem.body->modulus_factor); // nothing, where there is no map of stiffness
    hash.add(core::to_string(load_case.regime));
    hash.add_all(facets.condition);
    hash.add_all(facets.constraint);
    hash.add_all(facets.follows);
    hash.add_all(load_case.value);
    hash.add_all(load_case.node_factor);
    hash.add_all(load_case.node_shift);
    hash.add_all(facets.round_load);
    for (const auto &load : facets.round_loads) {
        hash.add_all(std::array{load.middle});
        hash.add_all(std::array{load.radius});
    }
    if (load_case.press_depth != 0.0) // others keep the name that they had before there was one
        hash.add_all(std::array{load_case.press_depth});
    add_events(hash, load_case, false);
    hash.add_all(std::array{load_case.acceleration});
    hash.add_all(load_case.path);
    for (const auto &name : facets.constraint_names)
        hash.add(name);
    add_events(hash, load_case, true);
}

std::string digits_of(const support::FnvHash &hash) {
    return fmt::format("{:016x}", hash.value());
}

} // namespace

FacetArrays facet_arrays(const core::LoadCase &load_case) {
    FacetArrays arrays;
    arrays.constraint_names = load_case.constraint_names();
    arrays.load_names = load_case.load_names();
    arrays.round_loads = load_case.round_loads();
    const auto num_facets = load_case.condition_on.size();
    const bool has_names =
        std::ranges::any_of(arrays.load_names, [](const std::string &name) { return !name.empty(); });
    if (has_names)
        arrays.load.assign(num_facets, -1);
    if (load_case.has(core::ConditionKind::pressure))
        arrays.follows.assign(num_facets, 0);
    if (!arrays.round_loads.empty())
        arrays.round_load.assign(num_facets, -1);
    std::vector<int> number_of_round;
    int num_round = 0;
    for (const auto &condition : load_case.conditions)
        number_of_round.push_back(condition.round ? num_round++ : -1);
    for (int f = 0; f < load_case.num_facets(); ++f) {
        const auto *condition = load_case.on(f);
        arrays.condition.push_back(!condition                 ? free_facet
                                   : condition->is_traction() ? traction_facet
                                                              : prescribed_facet);
        arrays.constraint.push_back(load_case.constraint_on(f));
        if (has_names)
            arrays.load[f] = load_case.load_on(f);
        if (load_case.follows_surface(f))
            arrays.follows[f] = 1;
        if (load_case.round_load_on(f))
            arrays.round_load[f] = number_of_round[load_case.condition_on[f]];
    }
    return arrays;
}

std::string problem_key(const core::Problem &problem) {
    ExactHash hash;
    hash.add(problem.body->name);
    hash.add(problem.load_case.name);
    hash.add(problem.load_case.definition);
    add_problem(hash, problem);
    hash.add_all(std::array{problem.load_case.load_scale});
    return digits_of(hash);
}

std::string fingerprint(const core::Problem &problem, const std::string &model) {
    RoundedHash hash;
    hash.add(model);
    add_problem(hash, problem);
    return digits_of(hash);
}

namespace {

template <class At> void describe_tool_errors(At at, const std::string &name, hdf5::Of<At, core::ToolErrors> &errors) {
    at.number(name + "_contact", errors.contact);
    at.number(name + "_after", errors.after);
    at.number(name + "_force", errors.force);
}

template <class At>
void describe_tool_reference(At at, hdf5::Of<At, ToolReference> &reference, const core::Problem &problem) {
    at.integer("level", reference.level);
    at.integer("steps_per_frame", reference.steps_per_frame);
    describe_tool_errors(at, "last_refinement", reference.last_refinement);
    describe_tool_errors(at, "half_steps", reference.half_steps);
    const int num_records = problem.load_case.tool.value().num_records();
    auto &history = reference.history;
    at.rows("time", history.time, "s", num_records);
    at.rows("force", history.force, "N", num_records);
    at.blocks("displacement", history.displacement, problem.body->mesh.points.size(), "m",
              core::ToolHistory::num_fields(num_records));
}

OutsideMotion motion_in(const std::filesystem::path &path, const core::Problem &problem) {
    const hdf5::InputFile file(path, "h5py.File(..., 'w', libver='latest')");
    const auto num_nodes = problem.body->mesh.points.size();
    const auto &tool = problem.load_case.tool.value();
    const auto num_records = static_cast<std::size_t>(tool.num_records());
    const std::size_t num_fields = core::ToolHistory::num_fields(tool.num_records());
    OutsideMotion motion;
    auto &history = motion.history;
    history.time = core::record_times(tool);
    history.force = file.dataset<core::Vector3>("/force", num_records);
    const auto fields = file.blocks<Eigen::Vector3f>("/displacement", num_nodes);
    const bool has_all = fields.size() == num_records * num_nodes;
    if (!has_all && fields.size() != num_fields * num_nodes)
        file.refuse("/displacement", fmt::format("has {} fields; it needs {}, at every record, or {}, at every fourth",
                                                 fields.size() / num_nodes, num_records, num_fields));
    for (std::size_t k = 0; k < num_records; ++k) {
        if (!core::ToolHistory::has_field(static_cast<int>(k)))
            continue;
        const std::size_t block = has_all ? k : k / core::ToolHistory::frames_per_field;
        const auto first = fields.begin() + static_cast<std::ptrdiff_t>(block * num_nodes);
        history.displacement.insert(history.displacement.end(), first, first + static_cast<std::ptrdiff_t>(num_nodes));
    }
    motion.seconds_per_frame = file.has_attribute("/", "seconds_per_frame") ? file.number("/", "seconds_per_frame")
                                                                            : std::numeric_limits<double>::quiet_NaN();
    return motion;
}

} // namespace

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

void write_tool_reference(const std::filesystem::path &path, const ToolReference &reference,
                          const core::Problem &problem, const Provenance &provenance) {
    hdf5::OutputFile file;
    hdf5::write_provenance(file, provenance);
    file.text("/", "body", problem.body->name);
    file.text("/", "load_case", problem.load_case.name);
    file.text("/", "model", reference.model);
    file.text("/", "fingerprint", fingerprint(problem, reference.model));
    describe_tool_reference(hdf5::GroupWriter(file).group("tool_reference"), reference, problem);
    support::write_whole(path, file.image());
}

std::optional<ToolReference> read_tool_reference(const std::filesystem::path &path, const core::Problem &problem,
                                                 const std::string &model) {
    std::error_code nobody_cares;
    if (!std::filesystem::exists(path, nobody_cares))
        return std::nullopt;
    const hdf5::InputFile file(path, "livermark arena --solve-reference");
    if (!file.has_attribute("/", "fingerprint") || file.text("/", "fingerprint") != fingerprint(problem, model))
        return std::nullopt;
    ToolReference reference;
    reference.model = model;
    describe_tool_reference(hdf5::GroupReader(file).on("tool_reference"), reference, problem);
    return reference;
}

void write_tool_scene(const std::filesystem::path &path, const core::Problem &problem, const ToolNodes &tool,
                      const Provenance &provenance) {
    const auto &mesh = problem.body->mesh;
    const auto &motion = problem.load_case.tool.value();
    hdf5::OutputFile file;
    hdf5::write_provenance(file, provenance);
    file.text("/", "body", problem.body->name);
    file.text("/", "load_case", problem.load_case.name);
    file.text("/", "title", problem.load_case.title);
    file.dataset("/points", mesh.points, "m");
    file.dataset("/tetrahedra", mesh.tetrahedra, "");
    file.dataset("/region", mesh.region, "");
    hdf5::describe_materials(hdf5::GroupWriter(file), problem.body->materials);
    file.dataset("/held", tool.held, "");
    file.group("/tool");
    file.dataset("/tool/time", core::record_times(motion), "s");
    file.dataset("/tool/nodes", tool.nodes, "");
    file.blocks("/tool/displacement", tool.displacement, tool.nodes.size(), "m");
    file.integer("/tool", "last_record_held", core::last_record_held(motion));
    file.number("/tool", "mass_damping", motion.mass_damping);
    support::write_whole(path, file.image());
}

OutsideMotion read_outside_motion(const std::filesystem::path &path, const core::Problem &problem) {
    return hdf5::read_once_tried(path, [&] { return motion_in(path, problem); });
}

} // namespace livermark::results
