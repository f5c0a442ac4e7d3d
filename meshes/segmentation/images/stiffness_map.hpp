#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/problem.hpp"
#include "meshes/segmentation/images/segmentation.hpp"

namespace livermark::segmentation {

/// An image of a modulus, such as elastography measures it.
struct StiffnessMap {
    std::string name; ///< of the file or folder
    ImageGrid grid;
    std::vector<float> modulus;         ///< (num_voxels) [Pa] the first axis runs fastest; NaN where nothing is known
    bool is_shear = false;              ///< whether it is the shear modulus mu, of which E = 2 (1 + nu) mu, and not E
    std::vector<std::string> remarks{}; ///< a sentence for what the file leaves in doubt
};

/// Meaning of the values of an image.
struct StiffnessValues {
    bool is_shear = false; ///< of the shear modulus, as wave elastography has it
    double pascals = 1.0;  ///< of a unit
};

/// Reads an image of a modulus in the formats of read_label_image(). Values that are 0, negative or no numbers are
/// holes: nothing was measured there.
/// @throws support::InputError as read_label_image(), and where the values cannot be those of soft tissue in this unit
StiffnessMap read_stiffness_map(const std::filesystem::path &file, const StiffnessValues &values);

/// Young's modulus of the tetrahedra of a body, and what a user should know of it.
struct MappedModulus {
    std::vector<double> young_modulus; ///< (M) [Pa] mean over the tetrahedron; NaN where less than half of it is known
    std::vector<std::string> remarks;  ///< a sentence each
};

/// Means of a map over tetrahedra: of points that are not farther apart than its voxels, up to 220 in a tetrahedron,
/// between whose eight voxels it is linear. The body has to be in the coordinates of the patient (LPS).
/// @param body  [m]
/// @throws support::InputError where the map covers less than half of the body
MappedModulus mapped_modulus(const StiffnessMap &map, const core::Body &body);

} // namespace livermark::segmentation
