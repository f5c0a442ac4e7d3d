#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/load_case.hpp"
#include "core/material.hpp"
#include "core/mesh/tetra_mesh.hpp"

namespace livermark::core {

/// A mesh with what it is made of.
struct Body {
    std::string name;
    TetraMesh mesh;
    std::vector<Material> materials; ///< (R) one per mesh.region_names
    /// Sentences on what its files do not say and somebody had to assume: units, materials, patches.
    std::vector<std::string> assumptions{};
    /// How clear the orientation is in which its patches were found, from 0 to 1; none where its files name them.
    std::optional<double> patch_confidence{};
};

/// What every model gets: a body and the load case put on its mesh. The body is shared between load cases.
struct Problem {
    std::shared_ptr<const Body> body;
    LoadCase load_case;
};

} // namespace livermark::core
