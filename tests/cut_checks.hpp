#pragma once

#include <random>
#include <string>

#include "meshes/cutting/cut.hpp"

namespace livermark::tests {

/// A cut at random: a region of the body with a margin, a half-space, or a blade with or without a thickness, along
/// facets or exactly. Many miss the body, or leave what floats.
meshes::Cut random_cut(const core::Body &body, std::mt19937 &random);

/// Whether a cut body is what meshes::cut() promises: tetrahedra of positive volume that are those before or parts of
/// them, none lost and none there twice; volume and mass conserved; a boundary that is closed, and at the wound a
/// manifold; one piece; no name without a facet or tetrahedron.
/// @return a sentence for the first fault; empty if there is none
std::string fault_of(const core::Body &before, const meshes::Cut &cut, const meshes::CutBody &after);

/// Cuts a body again and again, and checks it each time.
struct RandomCuts {
    int num_cut = 0, num_refused = 0;
    std::vector<std::string> faults; ///< with the number of the cut and its tool
};
RandomCuts try_random_cuts(const core::Body &body, int num_cuts, unsigned seed);

/// Fault of the boundary of a mesh that has been cut, in a sentence; empty if it is sound: it is that of the
/// tetrahedra, each of its edges has two triangles, from both sides, other than where the body before had more, and the
/// triangles around each node of the wound are one ring.
std::string fault_of_surface(const core::TetraMesh &mesh);

} // namespace livermark::tests
