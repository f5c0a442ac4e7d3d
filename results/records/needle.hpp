#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/load_case.hpp"
#include "core/tool/needle/needle.hpp"
#include "results/records/needle_arena.hpp"
#include "results/records/result.hpp"

namespace livermark::results {

/// A needle in the body of one model.
struct NeedleRun {
    std::string model;
    core::Insertion insertion;
    double setup_seconds = 0.0; ///< that its compliance took
    double solve_seconds = 0.0; ///< that the needle took in the body
    /// In the small regime: the depth from which on tissue at the needle is moved further than that is good for [m],
    /// see note_limit(); NaN if it never is.
    double left_regime_at = std::numeric_limits<double>::quiet_NaN();

    /// How far the target is from where it was at rest when the tip is there [m].
    core::Vector3 miss() const { return insertion.target[insertion.at_plan]; }
    /// How much tissue is left between tip and target then [m].
    double short_of_target(const core::Needle &needle) const {
        return needle.depth() - insertion.tip[insertion.at_plan];
    }
    double force_at_plan() const { return insertion.force[insertion.at_plan]; } ///< [N]
    double largest_force(const core::Needle &needle) const; ///< on the way in, when it punctures included [N]
    /// Finds left_regime_at.
    /// @param largest_small  see largest_small_displacement() [m]
    void note_limit(double largest_small);
    double largest_pull() const; ///< on the way out [N]; NaN where the body came to no rest on the way in
    /// What the hand did and is neither stored nor lost along the shaft, at the tip, across the axis or at the
    /// puncture, the most at a record, over all that it did on the way in: how exact the steps are.
    double energy_error() const;
};

/// One needle in all models; the first run is the reference.
struct NeedleStudy {
    core::Needle needle;
    std::vector<NeedleRun> runs;
    /// What the last refinement of the reference's mesh changed: of miss() [m], of the force as force_error(). NaN of
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

} // namespace livermark::results
