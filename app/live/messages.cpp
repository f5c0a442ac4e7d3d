#include "app/live/messages.hpp"

#include <bit>
#include <chrono>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <utility>

#include "app/live/parameters.hpp"

#include "core/support/input_error.hpp"

namespace livermark::live {

namespace {

static_assert(std::endian::native == std::endian::little, "messages are copied as they lie in memory");

/// Takes numbers from the front of a message.
class Numbers {
  public:
    explicit Numbers(std::span<const double> numbers) : left_(numbers) {}

    double number() {
        if (left_.empty())
            throw support::InputError("a message ends too early; load the page again");
        const double value = left_.front();
        left_ = left_.subspan(1);
        return value;
    }
    int integer() {
        const double value = number();
        if (!(std::abs(value) <= 1e9 && value == std::floor(value)))
            throw support::InputError(fmt::format("a message has {} where a whole number belongs", value));
        return static_cast<int>(value);
    }
    /// Number of things, each of which takes so many numbers.
    std::size_t count() {
        const int value = integer();
        if (value < 0 || static_cast<std::size_t>(value) > left_.size())
            throw support::InputError(fmt::format("a message says {} of something that is not in it", value));
        return static_cast<std::size_t>(value);
    }
    core::Vector3 vector() {
        const double x = number(), y = number();
        return {x, y, number()};
    }
    template <std::size_t n> std::array<int, n> integers() {
        std::array<int, n> values{};
        for (int &value : values)
            value = integer();
        return values;
    }
    void end() const {
        if (!left_.empty())
            throw support::InputError("a message is longer than it should be; load the page again");
    }

  private:
    std::span<const double> left_;
};

template <class T> void append(std::string &bytes, T value) {
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    bytes.append(raw, sizeof value);
}

void append_vector(std::string &bytes, const core::Vector3 &v) {
    for (const double x : v)
        append(bytes, x);
}

std::string choose(Scene &scene, Numbers &numbers) {
    const auto &names = spring_names();
    const int which = numbers.integer();
    if (which < 0 || which >= static_cast<int>(names.size()))
        throw support::InputError(fmt::format("there are no springs {}; take 0 to {}", which, names.size() - 1));
    Settings settings;
    settings.springs = names[which];
    settings.keeps_volume = numbers.integer() != 0;
    settings.young_modulus = numbers.number();
    settings.poisson_ratio = numbers.number();
    settings.damping.alpha = numbers.number();
    settings.damping.beta = numbers.number();
    settings.time_step = numbers.number();
    numbers.end();
    const auto chosen = scene.choose(settings);
    std::string bytes;
    for (const double number :
         {chosen.time_step, chosen.longest_time_step, chosen.critical_time_step, chosen.pressed_time_step})
        append(bytes, number);
    append(bytes, static_cast<double>(chosen.num_springs));
    append(bytes, chosen.unscaled_time_step);
    append(bytes, static_cast<double>(chosen.limit));
    return bytes;
}

std::string frame_bytes(const Frame &frame, double seconds) {
    const auto &load = frame.load;
    const auto count = [](const auto &list) { return static_cast<double>(list.size()); };
    std::string bytes;
    append(bytes, frame.time);
    append_vector(bytes, frame.tool);
    append_vector(bytes, frame.force);
    append_vector(bytes, load.shape.middle);
    append(bytes, load.shape.radius);
    for (const double number :
         {frame.indentation, frame.smallest_volume, frame.largest_speed, static_cast<double>(frame.restarts), seconds,
          static_cast<double>(frame.num_evaluations), count(frame.displacement), count(load.nodes),
          count(load.triangles)})
        append(bytes, number);
    for (const int node : load.nodes)
        append(bytes, static_cast<double>(node));
    for (const auto &force : load.nodal)
        append_vector(bytes, force);
    for (const int triangle : load.triangles)
        append(bytes, static_cast<double>(frame.surface->facet[triangle]));
    for (std::size_t l = 0; l < load.triangles.size(); ++l)
        append_vector(bytes, load.facet[l] / frame.surface->area[load.triangles[l]]);
    for (const auto &u : frame.displacement)
        for (const double x : u)
            append(bytes, static_cast<float>(x));
    return bytes;
}

/// Frame that follows a number of steps, the last of a message, and the time that they took.
struct TimedFrame {
    Frame frame;
    double seconds;
};

TimedFrame timed_frame(Scene &scene, const Tool &tool, Numbers &numbers) {
    using Clock = std::chrono::steady_clock;
    const int num_steps = numbers.integer();
    numbers.end();
    const auto start = Clock::now();
    auto frame = scene.move(tool, num_steps);
    return {std::move(frame), std::chrono::duration<double>(Clock::now() - start).count()};
}

std::string move(Scene &scene, Numbers &numbers) {
    Tool tool;
    tool.kind = static_cast<ToolKind>(numbers.integer());
    tool.target = numbers.vector();
    tool.radius = numbers.number();
    tool.node = numbers.integer();
    const auto [frame, seconds] = timed_frame(scene, tool, numbers);
    return frame_bytes(frame, seconds);
}

std::string press(Scene &scene, Numbers &numbers) {
    Tool tool{.kind = ToolKind::probe, .face = core::ToolFace::square};
    tool.target = numbers.vector();
    tool.inwards = numbers.vector();
    tool.radius = numbers.number();
    const auto [frame, seconds] = timed_frame(scene, tool, numbers);
    return frame_bytes(frame, seconds);
}

std::string prick(Scene &scene, Numbers &numbers) {
    Tool tool{.kind = ToolKind::needle};
    tool.needle.entry = numbers.vector();
    tool.needle.target = numbers.vector();
    for (double *const number : {&tool.needle.diameter, &tool.needle.spread, &tool.needle.toughness,
                                 &tool.needle.friction, &tool.needle.puncture_force, &tool.depth})
        *number = numbers.number();
    const auto [frame, seconds] = timed_frame(scene, tool, numbers);
    const auto reading = frame.needle.value_or(NeedleReading{}); // it is out where the motion was set back
    std::string bytes;
    for (const double number :
         {reading.depth, reading.tip, reading.force, reading.tip_force, static_cast<double>(reading.is_punctured)})
        append(bytes, number);
    append_vector(bytes, reading.target);
    for (const double number :
         {reading.work.hand, reading.work.friction, reading.work.tearing, static_cast<double>(reading.forces.size())})
        append(bytes, number);
    for (const auto &force : reading.forces)
        append_vector(bytes, force);
    return bytes + frame_bytes(frame, seconds);
}

std::string grasp(Scene &scene, Numbers &numbers) {
    Tool tool{.kind = ToolKind::grasp};
    tool.place = numbers.vector();
    tool.inwards = numbers.vector();
    tool.target = numbers.vector();
    tool.radius = numbers.number();
    tool.depth = numbers.number();
    const auto [frame, seconds] = timed_frame(scene, tool, numbers);
    const auto reading = frame.grasp.value_or(GraspReading{}); // it is off where the motion was set back
    std::string bytes;
    append(bytes, reading.depth);
    append(bytes, reading.closing);
    append_vector(bytes, reading.other);
    append_vector(bytes, reading.other_force);
    return bytes + frame_bytes(frame, seconds);
}

/// @param names  of the regions of the body
meshes::CutTool cut_tool(Numbers &numbers, const std::vector<std::string> &names) {
    const int kind = numbers.integer();
    if (kind == 0) {
        const int region = numbers.integer();
        if (region < 0 || region >= static_cast<int>(names.size()))
            throw support::InputError(fmt::format("there is no region {}; take 0 to {}", region, names.size() - 1));
        return meshes::RegionCut{names[region], numbers.number()};
    }
    if (kind == 1) {
        const auto point = numbers.vector();
        return meshes::HalfSpaceCut{point, numbers.vector()};
    }
    if (kind != 2)
        throw support::InputError(fmt::format("there is no cut {}; take 0, 1 or 2", kind));
    meshes::BladeCut blade;
    for (auto &corner : blade.corners)
        corner = numbers.vector();
    blade.thickness = numbers.number();
    return blade;
}

/// Changes that blades without thickness have made to a mesh.
struct MeshChanges {
    std::vector<int> nodes;      ///< that are new, or in other places, ascending
    std::vector<int> tetrahedra; ///< that have other nodes, ascending
};

MeshChanges changes_of(const core::TetraMesh &before, const core::TetraMesh &after) {
    MeshChanges changes;
    for (std::size_t node = 0; node < after.points.size(); ++node)
        if (node >= before.points.size() || after.points[node] != before.points[node])
            changes.nodes.push_back(static_cast<int>(node));
    for (std::size_t t = 0; t < after.tetrahedra.size(); ++t)
        if (after.tetrahedra[t] != before.tetrahedra[t])
            changes.tetrahedra.push_back(static_cast<int>(t));
    return changes;
}

std::string cut(Scene &scene, Numbers &numbers) {
    const auto start = std::chrono::steady_clock::now();
    const bool takes_loose = numbers.integer() != 0;
    const auto tool = cut_tool(numbers, scene.body().mesh.region_names);
    const bool is_region = std::holds_alternative<meshes::RegionCut>(tool);
    const bool keeps_margin = is_region && numbers.integer() != 0;
    const bool opens = is_region && numbers.integer() != 0;
    numbers.end();
    const auto reading =
        scene.cut({.tool = tool, .keeps_margin = keeps_margin, .takes_loose = takes_loose, .opens = opens});
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const auto gone = scene.gone();
    const auto &mesh = scene.remains().mesh;
    const auto constrained = scene.constrained_remains();
    const auto changes = changes_of(scene.original_mesh(), scene.body().mesh);
    std::string bytes;
    for (const double number : {reading.volume,
                                reading.way_volume,
                                reading.wound_area,
                                reading.margin,
                                reading.closed_volume,
                                reading.closed_depth,
                                reading.jagged.mean,
                                reading.jagged.worst,
                                reading.snapped.mean,
                                reading.snapped.worst,
                                static_cast<double>(reading.num_loose),
                                static_cast<double>(reading.num_pieces),
                                reading.seconds_to_find,
                                reading.seconds_to_check,
                                reading.seconds_of_springs,
                                seconds,
                                static_cast<double>(gone.size()),
                                static_cast<double>(mesh.boundary_triangles.size()),
                                static_cast<double>(changes.nodes.size()),
                                static_cast<double>(changes.tetrahedra.size())})
        append(bytes, number);
    for (const int tetrahedron : gone)
        append(bytes, static_cast<double>(tetrahedron));
    for (const auto &triangle : mesh.boundary_triangles)
        for (const int node : triangle)
            append(bytes, static_cast<double>(node));
    for (std::size_t f = 0; f < constrained.size(); ++f)
        append(bytes, scene.remains().facet[f] < 0 ? 2.0 : constrained[f] ? 1.0 : 0.0);
    for (const int node : changes.nodes) {
        append(bytes, static_cast<double>(node));
        append_vector(bytes, scene.body().mesh.points[node]);
        append(bytes, static_cast<double>(scene.original_node()[node]));
    }
    for (const int t : changes.tetrahedra) {
        append(bytes, static_cast<double>(t));
        for (const int node : scene.body().mesh.tetrahedra[t])
            append(bytes, static_cast<double>(node));
    }
    return bytes;
}

/// Patches of a body of which a capsule covers all but wounds, and whether facets are in these.
core::Capsule capsule(Numbers &numbers, core::TetraMesh &mesh) {
    core::Capsule capsule;
    capsule.thickness = numbers.number();
    capsule.young_modulus = numbers.number();
    mesh.patch_names.emplace_back(core::wound_patch);
    for (int &patch : mesh.boundary_patch)
        patch = numbers.integer() != 0 ? 0 : 1;
    return capsule;
}

core::VesselTree vessels(Numbers &numbers, std::size_t num_points) {
    core::VesselTree tree;
    const auto num_segments = numbers.count();
    for (std::size_t i = 0; i < num_points; ++i)
        tree.points.push_back(numbers.vector());
    for (std::size_t i = 0; i < num_points; ++i)
        tree.radius.push_back(numbers.number());
    for (std::size_t s = 0; s < num_segments; ++s)
        tree.segments.push_back(numbers.integers<2>());
    tree.wall_ratio = numbers.number();
    tree.wall_modulus = numbers.number();
    return tree;
}

/// @return nothing where nothing stands on springs
std::optional<core::Foundation> foundation(Numbers &numbers) {
    const auto num_facets = numbers.count();
    if (num_facets == 0)
        return std::nullopt;
    core::Foundation foundation;
    for (std::size_t i = 0; i < num_facets; ++i)
        foundation.facets.push_back(numbers.integer());
    for (std::size_t i = 0; i < num_facets; ++i)
        foundation.stiffness.push_back(numbers.number());
    for (std::size_t i = 0; i < num_facets; ++i)
        foundation.normal_only.push_back(numbers.integer() != 0 ? 1 : 0);
    return foundation;
}

} // namespace

std::unique_ptr<Scene> scene_of(std::span<const double> message) {
    Numbers numbers(message);
    const auto num_nodes = numbers.count(), num_tetrahedra = numbers.count(), num_regions = numbers.count(),
               num_triangles = numbers.count();
    core::Body body;
    for (std::size_t i = 0; i < num_nodes; ++i)
        body.mesh.points.push_back(numbers.vector());
    for (std::size_t t = 0; t < num_tetrahedra; ++t)
        body.mesh.tetrahedra.push_back(numbers.integers<4>());
    for (std::size_t t = 0; t < num_tetrahedra; ++t)
        body.mesh.region.push_back(numbers.integer());
    body.materials.resize(num_regions);
    for (auto &material : body.materials)
        material.density = numbers.number();
    for (auto &material : body.materials)
        material.young_modulus = numbers.number();
    for (auto &material : body.materials)
        material.poisson_ratio = numbers.number();
    for (std::size_t region = 0; region < num_regions; ++region)
        body.mesh.region_names.push_back(fmt::format("region {}", region));
    for (std::size_t f = 0; f < num_triangles; ++f)
        body.mesh.boundary_triangles.push_back(numbers.integers<3>());
    body.mesh.boundary_patch.assign(num_triangles, 0);
    body.mesh.patch_names = {"boundary"};
    std::vector<bool> is_constrained;
    for (std::size_t f = 0; f < num_triangles; ++f)
        is_constrained.push_back(numbers.integer() != 0);
    const auto num_factors = numbers.count();
    for (std::size_t t = 0; t < num_factors; ++t)
        body.modulus_factor.push_back(numbers.number());
    if (numbers.integer() != 0)
        body.capsule = capsule(numbers, body.mesh);
    if (const auto num_points = numbers.count(); num_points > 0)
        body.vessels = vessels(numbers, num_points);
    const auto below = foundation(numbers);
    numbers.end();
    return std::make_unique<Scene>(std::move(body), is_constrained, below);
}

std::string reply(Scene &scene, std::span<const double> message) {
    Numbers numbers(message);
    switch (numbers.integer()) {
    case 1:
        return choose(scene, numbers);
    case 2:
        return move(scene, numbers);
    case 3:
        numbers.end();
        scene.reset();
        return {};
    case 4:
        numbers.end();
        scene.keep();
        return {};
    case 5:
        numbers.end();
        scene.restore();
        return {};
    case 6:
        return prick(scene, numbers);
    case 7:
        return cut(scene, numbers);
    case 8:
        return grasp(scene, numbers);
    case 9:
        return press(scene, numbers);
    default:
        throw support::InputError("a message of a kind that nobody knows here; load the page again");
    }
}

std::string joined_spring_names() {
    return fmt::format("{}", fmt::join(spring_names(), ","));
}

} // namespace livermark::live
