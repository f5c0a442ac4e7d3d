#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh/places.hpp"
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
/// shaft is held, rigidly but for needle_stiffness or by a bed of springs along the shaft. All of it acts on places of
/// the radius `spread` on the axis, see InteriorPlace, and follows no mesh.
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
    /// Stiffness of the bed of springs that holds the tissue across the axis, for each metre of the shaft [N/m^2], > 0;
    /// infinite where needle_stiffness alone gives way.
    double side_stiffness = std::numeric_limits<double>::infinity();

    /// Softness of the bed at a place, beside that of needle_stiffness [m/N].
    /// @param spacing  of the places [m]
    double side_softness(double spacing) const { return 1.0 / (side_stiffness * spacing); }
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

/// Places on the axis of a needle, a third of their radius apart or a little less, from the entry on and some beyond
/// the target, which is one of them.
struct NeedleLine {
    std::vector<InteriorPlace> places; ///< (K)
    double spacing = 0.0;              ///< [m]
    int target = 0;                    ///< number of its place
};

/// @param needle  whose target is some way below its entry
NeedleLine needle_line(const Needle &needle);

/// The smallest radius of the places of a needle that points_of() surely finds points for, in the tetrahedra along it
/// [m]: it halves edges six times at most, and the last place may be two thirds of its radius outside the body.
double smallest_spread(const Needle &needle, const TetraMesh &mesh);

/// Length of the shaft that a place stands for: it falls linearly to zero at the places before and behind it [m].
/// @param place  0 ... K - 1
/// @param tip    how much of the tissue's path is behind the tip, measured at rest [m]
double shaft_length(const NeedleLine &line, int place, double tip);

/// The part that the place behind a point of the axis has of it; the next place has the rest.
struct PointOfLine {
    int below = 0;     ///< 0 ... K - 2
    double part = 1.0; ///< of that place, 0 to 1
};

/// @param point  from the entry on, at rest [m]
PointOfLine point_of_line(const NeedleLine &line, double point);

/// Places of a needle at rest under forces on them, and the energy that the body stores then.
struct PushedPlaces {
    Eigen::VectorXd displacement; ///< (3 K) means over the places [m]
    double stored = 0.0;          ///< strain energy [J]
};

/// A body as a needle sees it: places inside it that move under dead forces on them, slowly. Component i of place k has
/// number 3 k + i. A place is made of the same material points at every force, those of its ball at rest (see
/// InteriorPlace).
class PushedBody {
  public:
    PushedBody() = default;
    virtual ~PushedBody() = default;
    PushedBody(const PushedBody &) = delete;
    PushedBody &operator=(const PushedBody &) = delete;

    /// C, shape (3 K, 3 K) [m/N]: du / df of the body at rest, or near it. A linear body has it at every force; of
    /// another it is what a search for forces begins with, and no result depends on it.
    virtual const Eigen::MatrixXd &compliance() const = 0;

    /// Equilibrium under forces. A search for it begins at the last one that was found.
    /// @param force  shape (3 K) [N], in directions that stay in space
    /// @return nothing if no equilibrium is found
    virtual std::optional<PushedPlaces> push(const Eigen::VectorXd &force) = 0;
};

/// A linear body: u = C f.
class LinearPushedBody : public PushedBody {
  public:
    /// @param compliance  symmetric but for what solvers leave
    explicit LinearPushedBody(const Eigen::MatrixXd &compliance)
        : compliance_(0.5 * (compliance + compliance.transpose())) {}

    const Eigen::MatrixXd &compliance() const override { return compliance_; }
    std::optional<PushedPlaces> push(const Eigen::VectorXd &force) override {
        Eigen::VectorXd displacement = compliance_ * force;
        const double stored = 0.5 * force.dot(displacement);
        return PushedPlaces{std::move(displacement), stored};
    }

  private:
    Eigen::MatrixXd compliance_;
};

/// Goes from one force to another at once, or else in 2, 4, ... 32 equal parts, until an equilibrium is found.
/// @param begin  called before each attempt: goes back to where the body was under the first force
/// @param go_to  finds the equilibrium under a force (3 K) [N], from the last one; whether it did
/// @return whether it arrived
template <class Begin, class GoTo>
bool push_in_parts(const Eigen::VectorXd &from, const Eigen::VectorXd &to, const Begin &begin, const GoTo &go_to) {
    constexpr int most_parts = 32;
    for (int parts = 1; parts <= most_parts; parts *= 2) {
        begin();
        bool is_there = true;
        for (int part = 1; is_there && part <= parts; ++part)
            is_there = go_to(from + (to - from) * part / parts);
        if (is_there)
            return true;
    }
    return false;
}

} // namespace livermark::core
