#include <array>
#include <cmath>
#include <fmt/format.h>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "experiments/experiment.hpp"
#include "experiments/motion_capture.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "meshes/generators/box_generator.hpp"
#include "support/input_error.hpp"

namespace livermark::experiments::public_data {

namespace {

using core::Vector3;

constexpr int num_markers = 6, num_compared = 3; ///< the first three are near the tip, the others at the clamp
constexpr int held_frames = 10;                  ///< at the start, where a hand holds the beam
constexpr int frames_at_rest = 50;               ///< at the end
const Vector3 beam_size(0.1, 0.03, 0.03);        ///< [m]
/// Young's modulus as the authors fitted it to this beam.
constexpr core::Material dragon_skin{.density = 1070.0, .young_modulus = 263824.0, .poisson_ratio = 0.499};
/// Where the authors say that the markers are on the straight beam, with the clamp at x = 0 [m].
const std::array<Vector3, num_markers> nominal_markers{{{0.1, 0.015, 0.036},
                                                        {0.1, -0.006, 0.024},
                                                        {0.1, 0.036, 0.006},
                                                        {0.006, -0.01, -0.001},
                                                        {0.006, 0.04, 0.0275},
                                                        {0.006, 0.04, 0.0}}};

struct Weight {
    const char *name;
    const char *file; ///< between beam_ and _V2_a.c3d
    double force;     ///< [N]
    double held;      ///< about what holds the tip at the first turning point [N]
};
constexpr std::array<Weight, 3> weights{
    {{"0 N", "gravity", 0.0, 0.25}, {"0.510 N", "load52", 0.51012, 0.5}, {"1.001 N", "load101", 1.00062, 0.8}}};
constexpr double gravity = 9.81;       ///< [m/s^2]
constexpr int records_of_swings = 151; ///< of ring-downs: a second and a half
/// What a weight hangs at: the tetrahedra beside the upper edge of the free end [m].
const Vector3 weight_low(0.092, -1.0, 0.0225), weight_high(1.0, 1.0, 1.0);

std::string load_case_under(double force) {
    std::string text = R"(title = "A beam that is clamped at one end and bends under its weight"
regime = "large"
path = [0.5, 1.0]
target_peak_displacement = 0.03
acceleration = [0.0, 0.0, -9.81]
[[condition]]
patch = "x_min"
displacement = [0.0, 0.0, 0.0]
)";
    if (force > 0.0)
        text +=
            fmt::format("[[condition]]\nedge = {{ between = [\"x_max\", \"z_max\"], width = 0.006, length = 0.04 }}\n"
                        "force = [0.0, 0.0, {:.6f}]\n",
                        -force);
    return text;
}

/// While it rings down: a weight is a mass there, and a hand pulls the free end down until it lets go.
std::string load_case_of_swings(double held) {
    return load_case_under(0.0) + fmt::format("[[condition]]\npatch = \"x_max\"\nforce = [0.0, 0.0, {:.6f}]\n", -held);
}

core::LoadCase parsed(const std::string &text, const std::string &name, const core::TetraMesh &mesh) {
    auto made = load_cases::parse_load_case(text, "dragon_skin_beam.toml", mesh);
    made.name = name;
    return made;
}

core::Body beam(double edge_length) {
    return {.name = "dragon_skin_beam",
            .mesh = meshes::generate_box(beam_size, edge_length, meshes::BoxTopology::body_centred),
            .materials = {dragon_skin}};
}

core::Body beam_with(const Weight &weight, double edge_length) {
    return weight.force == 0.0 ? beam(edge_length)
                               : with_added_mass(beam(edge_length), weight.force / gravity, weight_low, weight_high);
}

/// Mean position of a marker over some frames, as the cameras see it [m].
Vector3 mean_of(const MotionCapture &capture, int marker, int first, int count) {
    Vector3 sum = Vector3::Zero();
    for (int frame = first; frame < first + count; ++frame)
        sum += capture.at(frame, marker);
    return sum / count;
}

/// Where the markers were, in the frame of the cameras [m].
struct Recording {
    std::array<Vector3, num_markers> held, at_rest;
    MotionCapture capture;

    /// Displacements from where a hand holds the beam at the start, turned, of compared markers.
    MarkerMotion motion(const Eigen::Matrix3d &rotation) const {
        MarkerMotion motion{1.0 / capture.frame_rate, num_compared, {}};
        for (int frame = 0; frame < capture.num_frames(); ++frame)
            for (int k = 0; k < num_compared; ++k)
                motion.displacement.emplace_back(rotation * (capture.at(frame, k) - held[k]));
        return motion;
    }
};

Recording read_recording(const std::filesystem::path &file) {
    auto capture = read_motion_capture(file);
    if (capture.num_markers != num_markers || capture.num_frames() < held_frames + frames_at_rest)
        throw support::InputError(fmt::format("{}: there are {} markers in {} frames, and {} in at least {} were "
                                              "recorded; take the public file",
                                              file.string(), capture.num_markers, capture.num_frames(), num_markers,
                                              held_frames + frames_at_rest));
    Recording recording;
    for (int k = 0; k < num_markers; ++k) {
        recording.held[k] = mean_of(capture, k, 0, held_frames);
        recording.at_rest[k] = mean_of(capture, k, capture.num_frames() - frames_at_rest, frames_at_rest);
    }
    recording.capture = std::move(capture);
    return recording;
}

/// How the beam rings under a weight, from the first turning point on in both recordings.
RingDown ring_down_of(const Weight &weight, std::span<const Recording> repeats, const Eigen::Matrix3d &rotation,
                      const std::string &place) {
    RingDown ring_down{.state = weight.name, .repeats = {}, .body = {}, .load_case = {}};
    for (const auto &repeat : repeats)
        ring_down.repeats.push_back(from_turning_point(repeat.motion(rotation), records_of_swings, place));
    ring_down.body = [weight](double edge_length) { return beam_with(weight, edge_length); };
    ring_down.load_case = [weight](const core::TetraMesh &mesh) {
        return parsed(load_case_of_swings(weight.held), weight.name, mesh);
    };
    return ring_down;
}

/// From the frame of the cameras to that of the beam, by all six markers while a hand holds the beam. The cameras see
/// it inclined by seven degrees.
RigidMotion frame_of_beam(const Recording &held_straight) {
    return best_rigid_motion(held_straight.held, nominal_markers);
}

Experiment read(const std::filesystem::path &folder) {
    Experiment experiment;
    experiment.assumptions = {
        "the clamp holds all of one end face, and its end is 100 mm from the free end",
        "the weight pulls on the 7.5 mm beside the upper edge of the free end, and keeps its direction",
        "the beam is straight where a hand holds it at the start; displacements are from there",
        "directions are those in which the six markers of the beam without a weight fit the places that the authors "
        "give best",
        "markers stand on pegs, which move with the surface under them",
        "while the beam rings, the weight is a mass in the tetrahedra at that edge, and the swing starts at its first "
        "turning point, in the shape that a force on the end face gives",
        "Young's modulus is the one that the authors fitted to this beam"};
    std::optional<RigidMotion> frame; // of the first recording, which has no weight
    for (const auto &weight : weights) {
        std::array<Recording, 2> repeats;
        for (std::size_t r = 0; r < repeats.size(); ++r)
            repeats[r] = read_recording(folder / fmt::format("beam_{}_V2_{}.c3d", weight.file, "ab"[r]));
        if (!frame) {
            frame = frame_of_beam(repeats[0]);
            for (int k = 0; k < num_compared; ++k)
                experiment.markers.push_back({fmt::format("{}", k), frame->at(repeats[0].held[k]), ""});
        }
        MeasuredState state{.name = weight.name, .load_case = {}, .displacement = {}};
        double difference = 0.0;
        for (int k = 0; k < num_compared; ++k) {
            const Vector3 a = frame->rotation * (repeats[0].at_rest[k] - repeats[0].held[k]);
            const Vector3 b = frame->rotation * (repeats[1].at_rest[k] - repeats[1].held[k]);
            state.displacement.emplace_back(0.5 * (a + b));
            difference += (a - b).squaredNorm() / num_compared;
        }
        state.noise = 0.5 * std::sqrt(difference); // of the mean of two
        state.load_case = [text = load_case_under(weight.force), name = state.name](const core::TetraMesh &mesh) {
            return parsed(text, name, mesh);
        };
        experiment.states.push_back(std::move(state));
        experiment.ring_downs.push_back(ring_down_of(weight, repeats, frame->rotation, folder.string()));
    }
    experiment.damping_from = weights[1].name;
    experiment.body = beam;
    experiment.edge_length = 0.0069; // bricks of 7.5 mm
    return experiment;
}

} // namespace

/// A clamped beam of silicone under its own weight and two others, seen by cameras (Dubied et al. 2022).
PublicExperiment dragon_skin_beam() {
    return {.name = {},
            .title = "Dragon Skin beam: a clamped beam of silicone under weights at its tip",
            .data = "dragon_skin_beam",
            .source = "Dubied et al. 2022, arXiv:2201.12560; python/realbeam_experiments/ of "
                      "github.com/srl-ethz/diffPD_sim2real, MIT",
            .read = read};
}

} // namespace livermark::experiments::public_data
