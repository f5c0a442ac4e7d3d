#pragma once

#include "core/problem.hpp"

/// The material of a body as one who handles it may choose it.
namespace livermark::live {

/// Index of the region with the largest volume, the first of several.
int largest_region(const core::TetraMesh &mesh);

/// The same body of another material. All keep their density.
/// @param young_modulus  of the largest region [Pa]; the others keep the ratio of theirs to it
/// @param poisson_ratio  of all regions
core::Body with_material(core::Body body, double young_modulus, double poisson_ratio);

} // namespace livermark::live
