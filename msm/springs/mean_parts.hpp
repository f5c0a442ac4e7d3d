#pragma once

#include <vector>

#include "msm/springs/coupled_springs.hpp"

namespace livermark::msm {

/// The parts of a body over which coupled springs take means of strains, of all kinds behind each other: around nodes,
/// around edges, and tetrahedra. Kinds without weight are left out. Where two materials meet stress jumps, so each has
/// parts of its own.
struct MeanParts {
    /// A part with some of a tetrahedron.
    struct Member {
        int part;
        double of_tetrahedron; ///< share of the tetrahedron that belongs to the part, times the weight of its kind
        double in_mean;        ///< weight of the tetrahedron in the mean: its volume in the part over that of the part
    };

    std::vector<double> volume;  ///< (C) at rest, times the weight of their kind [m^3]
    std::vector<double> modulus; ///< (C) shear modulus [Pa]
    std::vector<Member> members; ///< of each tetrahedron behind each other
    std::vector<int> start;      ///< (M + 1) where these begin

    int num_parts() const { return static_cast<int>(volume.size()); }
};

/// @param body  at rest, positive volumes
MeanParts mean_parts(const core::Body &body, const StrainDomains &domains);

} // namespace livermark::msm
