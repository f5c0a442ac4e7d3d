#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/model.hpp"
#include "results/records/cut.hpp"
#include "studies/cutting/growing_cut.hpp"

namespace livermark::studies {

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
