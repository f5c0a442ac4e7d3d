#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "core/relaxation.hpp"

/// Events: all that happens to a body beside the conditions on its surface. Each kind is a struct with
///
///     key           its table in load case files, and its group in result files
///     in_time       whether time passes; otherwise it belongs to the static solution
///     add_to(hash)  all of it that a solution depends on, in the order that names of stored references need
///
/// and, where it has a meaning for the kind,
///
///     noun          it in refusals: "a ball that touches"
///     scale(factor), cut_short(part)   what core::scaled() and core::cut_short() do to it
///     decides_statics                  whether its operator == counts for the static solution
///     move_to_parts(parent)            the facets that it lies on become those of a refined mesh;
///                                      parent has for each facet of that mesh
///                                      the one that it is a part of
///     contacts()                       what is known of its contacts before their facets are found
///
/// It is a member of Events and in EventKind, at the end of this file; load_cases/events/ has a reader for each.
namespace livermark::core {

/// A rigid tool that presses where contact finds it, as far as that is known before.
struct ExpectedContact {
    int constraint = 0;      ///< what it exerts: index into LoadCase::constraint_names()
    Vector3 middle;          ///< the first point of the body that is touched, at rest [m]
    double radius = 0.0;     ///< of what is touched at the full depth [m]
    Vector3 press;           ///< by which the tool moves inwards [m]
    double pressed_at = 1.0; ///< part of the load at which it has pressed; it slides after that
    bool grows = true;       ///< whether what is touched grows with the depth
};

/// Flat that the shape of a tool is rounded around.
enum class ToolFace : std::uint8_t {
    ball,  ///< a point
    round, ///< a disc
    square
};

/// The word for a face in load cases and files.
const char *to_string(ToolFace face);

/// Shape of a rigid tool that touches: all that is nearer than the radius to its flat, or to what is behind the flat of
/// a plate. So a ball is a point that is rounded, and a plate a block with a flat face, rounded edges and flanks.
struct ToolShape {
    double radius = 0.0; ///< R of a ball, or r of the edges of a plate [m], > 0
    ToolFace face = ToolFace::ball;
    double size = 0.0;                                      ///< a, radius of the disc or half a side [m]
    Vector3 axis = Vector3::Zero(), side = Vector3::Zero(); ///< out of the face; along two sides; length 1

    /// A ball, which a number stands for.
    ToolShape(double ball_radius = 0.0) : radius(ball_radius) {} // NOLINT(google-explicit-constructor)
    /// A plate; two sides of a square lie as near to an axis of coordinates as they can.
    /// @param press  along its axis
    ToolShape(ToolFace flat, double half_width, double edge_radius, const Vector3 &press);

    bool is_plate() const { return face != ToolFace::ball; }
    /// Radius of a ball around the middle of the flat that has the whole face [m].
    double reach() const { return (face == ToolFace::square ? std::sqrt(2.0) : 1.0) * size + radius; }
    /// Radius of what it touches when it is so deep [m]: the circle in which Hertz's sphere touches, or the flat.
    double contact_radius(double depth) const { return is_plate() ? size : std::sqrt(radius * depth); }
    bool operator==(const ToolShape &) const = default;
};

/// A rigid tool that touches the surface and does not stick to it: contact without adhesion, with Coulomb friction. It
/// does not turn. It may touch every facet that prescribes no displacement, see LoadCase::may_touch().
struct TouchingTool {
    ToolShape shape;
    Vector3 start = Vector3::Zero(); ///< centre of its flat when it just touches the body at rest [m]
    Vector3 press = Vector3::Zero(); ///< by which the centre moves inwards [m]
    Vector3 slide = Vector3::Zero(); ///< by which it moves after that [m]; zero where it only presses
    double friction = 0.0;           ///< coefficient mu, >= 0
    int constraint = 0;              ///< what it exerts on the body: index into LoadCase::constraint_names
    /// The point in which the ball is reflected into a second one, which closes against it like the other jaw of a
    /// forceps [m]. What the second one exerts is the next constraint. Nothing where there is one tool.
    std::optional<Vector3> between{};

    /// The part of the load at which it has pressed: all, or half where it slides.
    double pressed_at() const { return slide.isZero(0.0) ? 1.0 : 0.5; }
    /// Centre at a part of the load [m]: it presses evenly, then slides evenly.
    Vector3 centre_at(double part) const {
        const double until = pressed_at();
        if (part <= until)
            return start + part / until * press;
        return start + press + (part - until) / (1.0 - until) * slide;
    }
    /// Whether facets of this area vector are those of the other jaw: of two, they look the way that the first presses.
    bool is_for_other_jaw(const Vector3 &area) const { return between && area.dot(press) > 0.0; }
    /// Centre of the other jaw [m], where the first is at a centre.
    Vector3 other_centre(const Vector3 &centre) const { return 2.0 * between.value() - centre; }
    /// Point of it that touches the body at rest, or the middle of the face of a plate [m].
    Vector3 first_point() const { return start + shape.radius * press.normalized(); }
    bool operator==(const TouchingTool &) const = default;

    static constexpr const char *key = "touch", *noun = "a ball that touches";
    static constexpr bool in_time = false, decides_statics = true;
    std::vector<ExpectedContact> contacts() const {
        const ExpectedContact first{constraint, first_point(), shape.contact_radius(press.norm()),
                                    press,      pressed_at(),  !shape.is_plate()};
        if (!between)
            return {first};
        auto other = first;
        ++other.constraint;
        other.middle = other_centre(first.middle);
        other.press = -press;
        return {first, other};
    }
    void scale(double factor) {
        press *= factor;
        slide *= factor;
    }
    void cut_short(double part) {
        press *= std::min(1.0, part / pressed_at());
        slide *= part;
    }
    void add_to(auto &hash) const {
        hash.add_all(std::array{constraint});
        hash.add_all(std::array{start, press, slide});
        hash.add_all(std::array{shape.radius, friction});
        if (shape.is_plate())
            hash.add_all(std::array{static_cast<double>(shape.face), shape.size});
        if (between)
            hash.add_all(std::array{*between});
    }
};

/// A node whose motion is recorded.
struct Probe {
    std::string name;
    int node = 0; ///< number in the mesh
};

/// The motion after the static start: at t = 0 all tractions are let go. Prescribed displacements and the body's
/// acceleration stay as they were.
struct Release {
    int num_steps = 0;            ///< number of intervals that are recorded, >= 1
    double output_interval = 0.0; ///< between two records of the probes [s], > 0
    RayleighDamping damping;      ///< the same for every model
    std::vector<Probe> probes;    ///< at least one

    /// Whole fields are kept of every so many records only, so that there are no more than 51 of them.
    int records_per_frame() const { return (num_steps + 49) / 50; }
    /// F, the static start included
    int num_frames() const { return num_steps / records_per_frame() + 1; }
    bool is_frame(int record) const { return record % records_per_frame() == 0; }

    static constexpr const char *key = "release";
    static constexpr bool in_time = true;
    void add_to(auto &hash) const {
        hash.add_all(std::array{num_steps});
        hash.add_all(std::array{output_interval, damping.alpha, damping.beta});
        for (const auto &probe : probes)
            hash.add_all(std::array{probe.node});
    }
};

/// The way of a tool that has hold of a place from the start: it presses, slides and lets go, on a way that is known
/// before. All other places are held where they are.
struct ToolMotion {
    int constraint = 0;                         ///< what it exerts: index into LoadCase::constraint_names()
    double press_until = 0.0;                   ///< from t = 0 on, to the displacement of the place [s]
    Vector3 slide = Vector3::Zero();            ///< of the whole place, beside that [m]
    double slide_from = 0.0, slide_until = 0.0; ///< [s]
    double release_at = 0.0;                    ///< when the place is free again [s]
    int num_frames = 0;                         ///< number of those that are recorded after the start
    double frame_interval = 0.0;                ///< [s], > 0
    double mass_damping = 0.0;                  ///< alpha [1/s], >= 0: forces -alpha M v

    int num_records() const { return num_frames + 1; }                   ///< K, at t = 0 and after each frame
    double time_of(int record) const { return record * frame_interval; } ///< [s]

    static constexpr const char *key = "tool";
    static constexpr bool in_time = true;
    void add_to(auto &hash) const {
        hash.add_all(std::array{constraint, num_frames});
        hash.add_all(std::array{press_until, slide_from, slide_until, release_at, frame_interval, mass_damping});
        hash.add_all(std::array{slide});
    }
};

/// Loads of a body that relaxes, so slow that masses do not matter: everything that drives it (tractions, prescribed
/// displacements, depths, accelerations) grows with `factors`, linearly between the times. Solutions of it have a
/// core::PathPoint for each of the times; their other fields are those of whole_load_record().
struct SlowHistory {
    PronySeries relaxation;
    std::vector<double> times;   ///< (K) at which solutions are found [s], ascending from 0, K > 1
    std::vector<double> factors; ///< (K) of the loads, 0 at the start and 1 at most, which one of them is
    /// The record at which the last cycle of the load begins, and it ends with the last record; nothing without cycles.
    std::optional<int> last_cycle{};

    int num_records() const { return static_cast<int>(times.size()); }
    /// The last record of the whole load.
    int whole_load_record() const {
        const auto largest = std::max_element(factors.rbegin(), factors.rend());
        return static_cast<int>(std::distance(largest, factors.rend())) - 1;
    }
    bool operator==(const SlowHistory &) const = default;

    static constexpr const char *key = "slow_history";
    static constexpr bool in_time = true, decides_statics = true;
    void add_to(auto &hash) const {
        for (const auto *numbers : {&relaxation.moduli, &relaxation.times, &times, &factors})
            hash.add_all(*numbers);
    }
};

/// Places that stand on elastic springs, as ligaments and the diaphragm bear a liver: the traction on the body is -k u,
/// or -k n (n . u) with the normal n at rest, per area at rest. The energy is k / 2 |u|^2, or k / 2 (n . u)^2, per
/// area.
struct Foundation {
    std::vector<int> facets;       ///< (I) numbers in the mesh, ascending; none of them prescribes a displacement
    std::vector<double> stiffness; ///< (I) k below each [N/m^3], > 0
    std::vector<int> normal_only;  ///< (I) 1 where springs resist motion along the normal alone, otherwise 0

    /// K with the traction -K u on one of its facets [N/m^3].
    Eigen::Matrix3d stiffness_on(const TetraMesh &mesh, std::size_t which) const {
        if (normal_only[which] == 0)
            return stiffness[which] * Eigen::Matrix3d::Identity();
        const Vector3 normal = area_vector(mesh, facets[which]).normalized();
        return stiffness[which] * normal * normal.transpose();
    }
    bool operator==(const Foundation &) const = default;

    static constexpr const char *key = "foundation", *noun = "an elastic foundation";
    static constexpr bool in_time = false, decides_statics = true;
    void move_to_parts(std::span<const int> parent) {
        Foundation fine;
        for (std::size_t part = 0; part < parent.size(); ++part) {
            const auto found = std::lower_bound(facets.begin(), facets.end(), parent[part]);
            if (found == facets.end() || *found != parent[part])
                continue;
            const auto which = static_cast<std::size_t>(found - facets.begin());
            fine.facets.push_back(static_cast<int>(part));
            fine.stiffness.push_back(stiffness[which]);
            fine.normal_only.push_back(normal_only[which]);
        }
        *this = std::move(fine);
    }
    void add_to(auto &hash) const {
        hash.add_all(facets);
        hash.add_all(normal_only);
        hash.add_all(stiffness);
    }
};

/// The events of a load case, each kind at most once.
struct Events {
    std::optional<TouchingTool> touching;
    std::optional<Release> release;
    std::optional<ToolMotion> tool;
    std::optional<SlowHistory> slow_history;
    std::optional<Foundation> foundation;

    /// Optional events, for those who treat all of them alike.
    auto events() { return std::tie(touching, release, tool, slow_history, foundation); }
    auto events() const { return std::tie(touching, release, tool, slow_history, foundation); }
};

/// The kinds of events, in that order.
using EventKind = std::variant<TouchingTool, Release, ToolMotion, SlowHistory, Foundation>;

/// Some of the kinds.
class EventSet {
  public:
    template <class... Kinds> static constexpr EventSet of() {
        EventSet kinds;
        (kinds.add<Kinds>(), ...);
        return kinds;
    }
    static constexpr EventSet all() { return with_all(static_cast<EventKind *>(nullptr)); }
    template <class Kind> constexpr void add() { bits_ |= bit<Kind>(static_cast<EventKind *>(nullptr)); }
    template <class Kind> constexpr bool has() const { return has_all_of(of<Kind>()); }
    constexpr bool has_all_of(EventSet others) const { return (others.bits_ & ~bits_) == 0; }
    constexpr bool empty() const { return bits_ == 0; }

  private:
    template <class... Kinds> static constexpr EventSet with_all(std::variant<Kinds...> *) { return of<Kinds...>(); }
    template <class Kind, class... Kinds> static constexpr std::uint32_t bit(std::variant<Kinds...> *) {
        std::uint32_t found = 0, next = 1;
        ((found |= std::is_same_v<Kind, Kinds> ? next : 0U, next <<= 1U), ...);
        return found;
    }
    std::uint32_t bits_ = 0;
};

} // namespace livermark::core
