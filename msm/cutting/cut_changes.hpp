#pragma once

#include <vector>

namespace livermark::msm {

/// Numbers of what a cut has changed, as in StepParts, each ascending and once.
struct CutChanges {
    std::vector<int> tetrahedra; ///< that are gone
    std::vector<int> nodes;      ///< corners of these: their masses
    std::vector<int> springs;    ///< edges of these: their stiffness
    std::vector<int> volumes;    ///< control volumes that have lost some of their volume
    std::vector<int> edge_parts; ///< means around edges that have lost tetrahedra
};

} // namespace livermark::msm
