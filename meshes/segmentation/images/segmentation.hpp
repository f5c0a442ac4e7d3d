#pragma once

#include <map>
#include <string>
#include <vector>

#include "meshes/segmentation/images/label_image.hpp"

namespace livermark::segmentation {

/// Which labels of an image make the body. Where neither is given the codes and names of its segments decide, and where
/// it has none the smallest label is the liver, and every other one a tumour's.
struct LabelChoice {
    std::vector<int> liver; ///< its tissue
    std::vector<int> tumours;
};

/// Labels that are in an image, by the roles that their codes and names give them.
std::map<core::SegmentRole, std::vector<int>> labels_by_role(const LabelImage &image);

/// The volume of the labels that may belong to the body: those that are chosen, else those with names of a liver and
/// lesions, else all.
/// @return [m^3]
double labelled_volume(const LabelImage &image, const LabelChoice &choice);

/// A liver in one piece without cavities, and its lesions, in voxels.
struct Segmentation {
    ImageGrid grid;
    std::vector<std::uint8_t> region;      ///< (num_voxels) 0 outside the body, else 1 + index into region_names
    std::vector<std::string> region_names; ///< (R) "parenchyma", then "tumour_1" ..., largest first
    std::vector<std::string> remarks;      ///< a sentence for all that was left out, filled or taken for something else
    bool is_lps_by_header = false;         ///< whether the header of its file says how the patient lies
};

/// The volume of the voxels of each region.
/// @return (R) [m^3]
std::vector<double> region_volumes(const Segmentation &segmentation);

/// Picks the body out of an image: the largest piece of liver and tumours together; other pieces are left out, cavities
/// become parenchyma, and each connected piece of a tumour label is a lesion of its own, unless it is smaller than
/// smallest_lesion, in which case it becomes parenchyma. Vessels and ducts have no region: where they are enclosed they
/// become parenchyma, elsewhere they are holes. Nothing of this goes unsaid.
/// @param smallest_lesion  [m^3]
/// @throws support::InputError  if a label that was asked for is not in the image, if segments have names and none is
///                           that of a liver, if nothing is left, or if there are more lesions than a body can have
///                           (254)
Segmentation choose_labels(const LabelImage &image, const LabelChoice &choice, double smallest_lesion);

} // namespace livermark::segmentation
