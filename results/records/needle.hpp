#pragma once

#include <filesystem>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/load_case.hpp"
#include "core/tool/needle/needle.hpp"
#include "results/records/arena.hpp"
#include "results/records/result.hpp"
#include "results/tables/table_layout.hpp"

namespace livermark::results {

/// Three numbers of what the hand feels.
struct NeedleForces {
    double peak = 0.0;  ///< the largest on the way in [N]
    double slope = 0.0; ///< over depth, by least squares over the second half of the way in [N/m]: friction
    double pull = 0.0;  ///< the largest outwards after that [N]

    bool operator==(const NeedleForces &) const = default;
};

/// @param depth    (K) of the tip [m]
/// @param force    (K) of the hand, inwards [N]
/// @param at_plan  the last record of the way in
NeedleForces needle_forces(const std::vector<double> &depth, const std::vector<double> &force, int at_plan);

/// A method with a needle, on a mesh within a budget. Records are those of NeedleArena.
struct NeedleArenaRun {
    std::string method;
    std::string setting; ///< how it uses its time
    int tetrahedra = 0;  ///< of the mesh
    double budget = 0.0; ///< of one core, for a frame [s]
    int steps = 0;       ///< in a frame
    int iterations = 0;  ///< in a step
    int stops_early = 0; ///< as of ArenaRun
    ArenaOutcome outcome = ArenaOutcome::ok;
    std::vector<double> force;         ///< (K) of the hand, inwards [N]; NaN from where the body has diverged on
    std::vector<double> tip;           ///< (K) how much of the tissue's path is behind the tip, at rest [m]
    std::vector<core::Vector3> target; ///< (K) displacement of the target [m]
    double target_error = 0.0;         ///< of the displacement of the target at at_plan [m]
    double path_error = 0.0; ///< of displacements at the places of the needle there, sqrt(sum |u - r|^2 / sum |r|^2)
    NeedleForces forces;
    double frame_seconds = 0.0;    ///< of the processor, median over frames [s]
    double frame_seconds_95 = 0.0; ///< 95th percentile [s]
    double worst_frame_seconds = 0.0;
    double cost_ratio = 0.0;    ///< of a frame over one of the same body without the needle, of medians taken by turns
    double setup_seconds = 0.0; ///< before the first frame
    double calibration_spread = 0.0; ///< as of ArenaRun

    bool operator==(const NeedleArenaRun &) const = default;
};

/// A method that holds no needle, and why.
struct LeftOut {
    std::string method, because;

    bool operator==(const LeftOut &) const = default;
};

/// Methods that move under one needle, frame by frame. The reference is the static insertion of the needle study at the
/// same depths: between its records linear, at rest that of the plan, and after it is out of the body that of its end.
struct NeedleArena {
    double speed = 0.0;                          ///< of the hand [m/s]
    double rest = 0.0;                           ///< at the target [s]
    double mass_damping = 0.0;                   ///< alpha [1/s]
    double frame_interval = 0.0;                 ///< [s]
    int at_plan = 0;                             ///< record at which the hand has led the tip to the target
    std::vector<double> depth;                   ///< (K) as the hand leads the tip, at rest and after each frame [m]
    std::vector<double> reference_force;         ///< (K) [N]
    std::vector<core::Vector3> reference_target; ///< (K) [m]
    NeedleForces reference_forces;
    /// Change of these by the last refinement of its mesh; NaN of one that has no finer mesh.
    NeedleForces reference_changes{.peak = std::numeric_limits<double>::quiet_NaN(),
                                   .slope = std::numeric_limits<double>::quiet_NaN(),
                                   .pull = std::numeric_limits<double>::quiet_NaN()};
    std::vector<NeedleArenaRun> runs;
    std::vector<LeftOut> left_out;
};

/// A needle in the body of one model.
struct NeedleRun {
    std::string model;
    core::Insertion insertion;
    double setup_seconds = 0.0; ///< that its compliance took
    double solve_seconds = 0.0; ///< that the needle took in the body
    /// Depth, in the small regime, from which on tissue at the needle is moved further than that is good for [m],
    /// see note_limit(); NaN if it never is.
    double left_regime_at = std::numeric_limits<double>::quiet_NaN();

    /// Way of the target from its place at rest when the tip is there [m].
    core::Vector3 miss() const { return insertion.target[insertion.at_plan]; }
    /// Tissue that is left between tip and target then [m].
    double short_of_target(const core::Needle &needle) const {
        return needle.depth() - insertion.tip[insertion.at_plan];
    }
    double force_at_plan() const { return insertion.force[insertion.at_plan]; } ///< [N]
    double largest_force(const core::Needle &needle) const; ///< on the way in, when it punctures included [N]
    /// Finds left_regime_at.
    /// @param largest_small  see largest_small_displacement() [m]
    void note_limit(double largest_small);
    double largest_pull() const; ///< on the way out [N]; NaN where the body came to no rest on the way in
    /// Work of the hand that is neither stored nor lost along the shaft, at the tip, across the axis or at the
    /// puncture, the most at a record, over all that it did on the way in: how exact the steps are.
    double energy_error() const;
};

/// One needle in all models; the first run is the reference.
struct NeedleStudy {
    core::Needle needle;
    std::vector<NeedleRun> runs;
    /// Changes by the last refinement of the reference's mesh: of miss() [m], of the force as force_error(). NaN of
    /// one that has no finer mesh.
    double reference_miss_change = std::numeric_limits<double>::quiet_NaN();
    double reference_force_change = std::numeric_limits<double>::quiet_NaN();
    std::optional<NeedleArena> arena{}; ///< of `livermark arena --tool needle`
};

/// All needles of a load case in a body: the content of one needle file.
struct NeedleFile {
    Provenance provenance;
    std::string body, load_case, title;
    core::Regime regime = core::Regime::small;
    std::vector<NeedleStudy> needles; ///< at least one, all with the same models
};

/// sqrt(sum_j (F - R)^2 / sum_j R^2) over the records of the way in.
double force_error(const core::Insertion &insertion, const core::Insertion &reference);

/// A model beside a measured needle: what was fitted, and what came out.
struct FittedNeedle {
    std::string model;
    double stiffness = 1.0;    ///< by which all of Young's moduli are multiplied, fitted to the depth of the puncture
    double friction = 0.0;     ///< fitted to the forces behind the puncture [N/m]
    bool has_friction = true;  ///< it is below the most that is tried; else no friction follows the forces
    core::Insertion insertion; ///< on the way in and out
    std::vector<double> force; ///< (B) its mean in each stretch of the measurement [N]; NaN where it has no record
    double error = 0.0;        ///< root mean square of force less measured mean, behind the puncture [N]
    double error_before = 0.0; ///< the same before it [N]
    double work = 0.0;         ///< of the hand, over all stretches [J]
    /// Largest on the way out, which nothing is fitted to [N]; NaN where the body came to no rest.
    double pull = std::numeric_limits<double>::quiet_NaN();
};

/// Models beside what was measured at the handle of a needle.
struct MeasuredNeedle {
    std::string name{}; ///< of the record
    std::string source;
    std::vector<std::string> unknown;
    core::Needle needle; ///< with what is not fitted: diameter, radius of the places, toughness, force of the puncture
    std::vector<double> from, to, mean, lowest, highest; ///< (B) stretches of the way [m], and the forces there [N]
    double puncture_depth = 0.0;                         ///< [m]
    double work = 0.0;                                   ///< of the hand, measured, over all stretches [J]
    std::vector<FittedNeedle> runs;
    std::vector<std::string> changed{}; ///< sentences on numbers of the load case that the record does not allow
    /// Numbers of the record without a model: where the needle touched [m], the smallest force behind the puncture [N],
    /// the slope of the means behind it [N/m]; and the largest pull on the way out [N], for how long the needle was
    /// held [s] and the forces when that began and ended [N], NaN where they were not recorded.
    double touched_at = 0.0, lowest_behind = 0.0, slope = 0.0;
    double pull = std::numeric_limits<double>::quiet_NaN(), held_for = std::numeric_limits<double>::quiet_NaN();
    double held_from = std::numeric_limits<double>::quiet_NaN(), held_to = std::numeric_limits<double>::quiet_NaN();
};

/// The "Needle files" of results/schema.md; errors as of write_result() and read_result().
void write_needles(const std::filesystem::path &path, const NeedleFile &needles);
NeedleFile read_needles_file(const std::filesystem::path &path);

/// A row for each needle and model, the reference first: numbers of NeedleRun when the tip is where the target was, and
/// what they are off by.
Layout needle_table(const NeedleFile &file);

/// A sentence on where models leave the small regime; empty where none does.
std::string limit_note(const NeedleStudy &study);

/// The same of each needle, where energies do not balance or a body came to no rest, and a sentence on each reference:
/// what its last refinement changed.
std::string needle_note(const NeedleFile &file);

/// A row for each stretch of a measured way: the mean, lowest and highest force there, and that of each model [N].
Layout measured_needle_table(const MeasuredNeedle &measured);

/// A row for each model: what was fitted, and how far its force is from the measured one before and behind the puncture
/// [N]; and the work of the hand [mJ] and, where it was measured, the largest pull on the way out [N], beside the
/// measured ones.
Layout fitted_needle_table(const MeasuredNeedle &measured);

/// A row for each record: its phases, and the friction of the first model, which is that of the slope behind the
/// puncture if all of it is friction.
/// @param records  shape (R), R >= 1, with a run each
Layout needle_records_table(std::span<const MeasuredNeedle> records);

/// A row for each run of a needle in the arena, by mesh and budget, the best target first; forces have what they are
/// off by behind them.
Layout needle_arena_table(const NeedleArena &arena);

/// Sentences on the needle, its reference with its error bar, and the methods that are left out.
std::string needle_arena_note(const NeedleStudy &study);

} // namespace livermark::results
