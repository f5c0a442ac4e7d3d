#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "meshes/segmentation/images/label_image.hpp"

namespace livermark::segmentation {

/// A way in which a header says how the image lies, in LPS and metres.
struct Placement {
    Eigen::Matrix3d direction = Eigen::Matrix3d::Identity().eval(); ///< columns: the image's axes, of length 1
    std::optional<core::Vector3> origin{};                          ///< centre of the first voxel
};

/// Grid of a header, read without the library that reads the voxels.
struct HeaderGrid {
    std::optional<std::array<int, 3>> size{};
    std::optional<core::Vector3> spacing{}; ///< [m]
    std::vector<Placement> placements{};    ///< none if it says nothing; two if NIfTI has both its forms
    std::vector<std::string> remarks{};     ///< a sentence for what it leaves in doubt
};

/// Reads the header of NIfTI-1 (.nii, .hdr, compressed or not), NRRD (https://teem.sourceforge.net/nrrd/format.html) or
/// MetaImage; of other formats it says nothing.
/// @throws support::InputError if the header contradicts itself, or says something whose meaning is not known: a unit,
/// a space that would mirror the body
HeaderGrid grid_in_header(const std::filesystem::path &file);

/// Compares the grid that ITK has read with the header, and corrects it. Of two placements the one counts that ITK has
/// chosen. ITK 5.2 takes the origin of NIfTI for millimetres whatever the unit is, turns left-anterior-superior NRRD by
/// half a circle (InsightSoftwareConsortium/ITK#5207), and knows no unit of NRRD.
/// @param file  for messages
/// @param remarks  gets a sentence if something is corrected
/// @throws support::InputError if both count other voxels
void correct_by_header(ImageGrid &grid, const HeaderGrid &header, const std::string &file,
                       std::vector<std::string> &remarks);

} // namespace livermark::segmentation
