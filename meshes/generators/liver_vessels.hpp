#pragma once

#include <span>

#include "core/vessels.hpp"

namespace livermark::meshes {

/// Veins of the liver.
enum class LiverVein { hepatic, portal };

/// A straight piece of a vein.
struct VeinTrunk {
    LiverVein vein;
    core::Vector3 begin, end; ///< of its axis, in the axes of liver_level() [m]
    double radius;            ///< [m]
};

/// Trunks as thick as an adult's, in the liver that ships: the hepatic one comes from the vena cava and parts into a
/// middle and a right vein, the portal one comes from the porta hepatis and parts into a right and a left branch. They
/// pass the lesions.
std::span<const VeinTrunk> liver_vein_trunks();

/// Both trees of the liver that ships, down to twigs of a radius of 1.2 mm: from the trunks on, a twig goes from the
/// nearest point of a tree to each of so many points drawn in the liver, 6 mm below its surface, that are not near the
/// tree yet. Radii are Murray's, r^3 before a fork is the sum of those behind it (1926, PNAS 12), so that both
/// trunks have 5.3 mm. No twig is a patient's; lengths and radii are those of an adult.
/// @return with the usual wall of meshes/io/vessel_files.hpp; the tree of the hepatic veins comes first
core::VesselTree liver_veins(int twigs_of_each = 125);

} // namespace livermark::meshes
