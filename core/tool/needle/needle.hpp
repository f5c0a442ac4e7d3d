#pragma once

#include <limits>
#include <string>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::core {

/// Stiffness with which a needle holds each of its places [N/m], along the axis and across it. A place gives way by its
/// force over the stiffness: 4 um for the tip force of a biopsy. Places overlap, so that forces that alternate from
/// place to place hardly move the tissue: held rigidly they would be a hundred times what the hand exerts, and differ
/// with whatever rounding there is.
inline constexpr double needle_stiffness = 5e4;

/// A straight, rigid needle that is driven from a point of the surface to a target and drawn out again, slowly.
///
/// At the tip it exerts what the tissue takes to tear, along the shaft friction; across its axis the tissue at the
/// shaft is held. All of it acts on places of the radius `spread` on the axis, see InteriorPlace, and follows no mesh.
struct Needle {
    std::string name;
    Vector3 entry = Vector3::Zero();  ///< on the surface of the body [m]
    Vector3 target = Vector3::Zero(); ///< inside [m]
    double diameter = 0.0;            ///< w [m]
    double spread = 0.0;              ///< radius of the places [m]
    double toughness = 0.0;           ///< G, of the tissue [J/m^2]: the tip exerts G w
    double friction = 0.0;            ///< along the shaft, over its length inside [N/m]
    double puncture_force = 0.0;      ///< at which the surface gives way [N], >= G w
    double step = 0.0;                ///< by which it is driven from record to record [m]

    double tip_force() const { return toughness * diameter; } ///< [N]
    double depth() const { return (target - entry).norm(); }  ///< from entry to target, the body at rest [m]
    Vector3 direction() const { return (target - entry).normalized(); }
};

/// Forces and places of a needle, J records: the first before it touches, then after each step in, the last of which
/// brings the tip to where the target was at rest, and after each step out until it is out of the body.
struct Insertion {
    std::vector<double> depth;    ///< (J) of the tip below the entry at rest [m]
    std::vector<double> force;    ///< (J) of the hand, inwards [N]
    std::vector<double> tip;      ///< (J) how much of the tissue's path is behind the tip, measured at rest [m]
    std::vector<Vector3> target;  ///< (J) displacement of the target [m]
    std::vector<double> entry;    ///< (J) displacement of the tissue at the entry, inwards [m]
    std::vector<double> work;     ///< (J) of the hand so far [J]
    std::vector<double> stored;   ///< (J) in the tissue [J]
    std::vector<double> friction; ///< (J) lost along the shaft so far [J]
    std::vector<double> tearing;  ///< (J) lost at the tip so far [J]
    std::vector<double> holding;  ///< (J) lost where the tissue is held across the axis so far [J]; not in old files
    /// Depth at which the surface gives way; NaN if it does not.
    double puncture_depth = std::numeric_limits<double>::quiet_NaN();
    /// Energy that is set free when it does, and no step of the hand takes up: the needle jumps [J].
    double puncture_loss = 0.0;
    /// Depth at which the body came to no rest, see studies::insert(); NaN if it always did.
    double stopped_at = std::numeric_limits<double>::quiet_NaN();
    int at_plan = 0; ///< record at which the tip is where the target was at rest
    /// (K) displacement of the places of needle_line() at this record [m]; not in files, and empty where nobody found
    /// it.
    std::vector<Vector3> places{};
    std::vector<double> moved{}; ///< (J) largest displacement of the places [m]; the same

    int num_records() const { return static_cast<int>(depth.size()); }
};

} // namespace livermark::core
