#pragma once

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/model.hpp"
#include "core/problem.hpp"
#include "core/solution.hpp"
#include "results/records/cut.hpp"

namespace livermark::studies {

/// A blade that goes into a body in equal steps. It parts the body and takes nothing away.
struct BladeWay {
    /// In turn [m]. The blade's edge begins at 0-1 and ends at 3-2.
    std::array<core::Vector3, 4> corners;
    int num_steps = 20; ///< >= 1

    double depth() const; ///< how far the middle of the edge goes [m]
    /// What the edge sweeps from one depth to another, as parts of the way.
    std::array<core::Vector3, 4> swept(double from, double to) const;
};

/// A body on the way.
struct CutStage {
    std::shared_ptr<const core::Body> body; ///< at rest
    double depth = 0.0;                     ///< of the blade's edge along its way [m]
    double area = 0.0;                      ///< cut so far, of one side, at rest [m^2]
    double seconds = 0.0;                   ///< that the last cut took
    /// (M) of each tetrahedron its number in the stage before; empty where the last step has parted nothing.
    std::vector<int> parents{};
    /// Nodes that were one before they were parted, two by two.
    std::vector<std::array<int, 2>> parted{};
};

/// Where the nodes of a body are when the blade goes on, as displacements [m]; it is asked before each step.
using DisplacementOf = std::function<std::vector<core::Vector3>(const CutStage &stage)>;

/// Divides a body along facets, step by step. The blade is where it is in space, and meets the body as that is then; a
/// step on which it parts no face changes nothing.
/// @param displacement_of  nothing for a body that stays at rest
/// @return num_steps + 1, the first as the body was
/// @throws support::InputError   for a blade that is none
/// @throws meshes::CutNotOnBody  if no step parts anything, or the body falls apart
std::vector<CutStage> grow_cut(std::shared_ptr<const core::Body> body, const BladeWay &way,
                               const DisplacementOf &displacement_of);

/// The same body with all of the blade's way cut in one step, exactly: tetrahedra are split at it. It ends at a face,
/// up to an edge short of the end of the way.
/// @throws meshes::CutNotOnBody  if it parts nothing, or the body falls apart
CutStage cut_exactly(const core::Body &body, const BladeWay &way);

/// How far the two sides of a cut are apart where they are furthest [m].
double opening(const CutStage &stage, const std::vector<core::Vector3> &displacement);

/// Stiffness where the body is touched, core::stiffness_at() the first tool [N/m]; NaN without one.
double stiffness_at_first_tool(const core::Problem &problem, const core::Solution &solution);

/// Nodes of the edges at which a cut ends inside the body: there the two sides of the wound meet, and have the material
/// around them. Stresses are singular there.
/// @return (N)
std::vector<bool> wound_rim_nodes(const core::TetraMesh &mesh);

/// Solves a model on a cut body, and on meshes that are finer and finer: tetrahedra at the rim of the wound and at the
/// rims of the places of the load case have all their edges cut in two, again and again. Openings are at the nodes of
/// the coarsest mesh. What has no equilibrium ends it.
/// @param way      of the blade
/// @param cut      for CutLevel::way
/// @param problem  on the body of the stage
/// @param times    how often meshes are refined
/// @param begins   called before each mesh
/// @return times + 1 levels, or fewer; the message of the level that has no equilibrium is in failure
std::vector<results::CutLevel> solve_finer_at_wound(const core::Model &model, const BladeWay &way,
                                                    const std::string &cut, const CutStage &stage,
                                                    const core::Problem &problem, int times,
                                                    const std::function<void()> &begins, std::string &failure);

} // namespace livermark::studies
