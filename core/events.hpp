#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>
#include <variant>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "core/rayleigh_damping.hpp"
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
///     contact()                        what is known of a contact before its facets are found
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
};

/// A rigid ball that touches the surface and does not stick to it: contact without adhesion, with Coulomb friction. The
/// ball does not turn. It may touch every facet that prescribes no displacement, see LoadCase::may_touch().
struct TouchingTool {
    double radius = 0.0;             ///< R [m], > 0
    Vector3 start = Vector3::Zero(); ///< its centre when it just touches the body at rest [m]
    Vector3 press = Vector3::Zero(); ///< by which the centre moves inwards [m]
    Vector3 slide = Vector3::Zero(); ///< by which it moves after that [m]; zero where it only presses
    double friction = 0.0;           ///< coefficient mu, >= 0
    int constraint = 0;              ///< what it exerts on the body: index into LoadCase::constraint_names

    /// The part of the load at which it has pressed: all, or half where it slides.
    double pressed_at() const { return slide.isZero(0.0) ? 1.0 : 0.5; }
    /// Centre of the ball at a part of the load [m]: it presses evenly, then slides evenly.
    Vector3 centre_at(double part) const {
        const double until = pressed_at();
        if (part <= until)
            return start + part / until * press;
        return start + press + (part - until) / (1.0 - until) * slide;
    }
    /// Point at which the ball touches the body at rest [m].
    Vector3 first_point() const { return start + radius * press.normalized(); }
    bool operator==(const TouchingTool &) const = default;

    static constexpr const char *key = "touch", *noun = "a ball that touches";
    static constexpr bool in_time = false, decides_statics = true;
    /// As large as the circle in which Hertz's sphere touches.
    ExpectedContact contact() const {
        return {constraint, first_point(), std::sqrt(radius * press.norm()), press, pressed_at()};
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
        hash.add_all(std::array{radius, friction});
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

/// The events of a load case, each kind at most once.
struct Events {
    std::optional<TouchingTool> touching;
    std::optional<Release> release;
    std::optional<ToolMotion> tool;
    std::optional<SlowHistory> slow_history;

    /// Optional events, for those who treat all of them alike.
    auto events() { return std::tie(touching, release, tool, slow_history); }
    auto events() const { return std::tie(touching, release, tool, slow_history); }
};

/// The kinds of events, in that order.
using EventKind = std::variant<TouchingTool, Release, ToolMotion, SlowHistory>;

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
