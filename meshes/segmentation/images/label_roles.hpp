#pragma once

#include <map>
#include <string>
#include <vector>

#include "meshes/segmentation/images/segmentation.hpp"

/// Parts of the body that the labels of an image make, by names, codes and choice. Internal to segmentation/.
namespace livermark::segmentation {

/// Part that a label makes.
struct LabelPart {
    core::SegmentRole role = core::SegmentRole::other;
    std::string region{}; ///< of a vessel: vessel, vessel_hepatic ...; empty if it has none, such as the vena cava
};

/// Part of each label that voxels have.
using LabelParts = std::map<int, LabelPart>;

/// Parts of the labels of an image by choice, codes and names.
/// @param remarks  gets a sentence for what was decided without being asked
/// @throws support::InputError
LabelParts parts_of_labels(const LabelImage &image, const LabelChoice &choice, std::vector<std::string> &remarks);

/// Labels with a role, in ascending order.
std::vector<int> labels_with(const LabelParts &parts, core::SegmentRole role);

/// Labels that voxels have, but for the background, in ascending order.
std::vector<int> labels_in(const LabelImage &image);

/// Label and name: 3 'Hepatic vein'.
std::string shown_label(const LabelImage &image, int label);
std::string shown_labels(const LabelImage &image, const std::vector<int> &labels);

} // namespace livermark::segmentation
