#pragma once

#include "segmentation/images/label_image.hpp"

namespace livermark::segmentation {

inline constexpr int phantom_liver_label = 1;
inline constexpr int phantom_first_tumour_label = 2; ///< of the largest lesion; the others follow

/// How the phantom is scanned.
struct PhantomOptions {
    core::Vector3 spacing = {0.8e-3, 0.8e-3, 3e-3}; ///< of the voxels [m]
    core::Vector3 turn = {0.0, 0.0, 0.0};           ///< rotation vector of the image's axes against the patient's [rad]
    bool touching = false; ///< the second lesion moved to the capsule, and the fifth to the first
};

/// The liver that ships with its six lesions, as somebody would have segmented it: a voxel is what lies at its centre.
LabelImage phantom_labels(const PhantomOptions &options);

/// A scan of it: grey values of a portal venous phase (liver 110 HU, lesions 70 HU, fat around it -90 HU), blurred over
/// a voxel and with noise of 12 HU; the same every time.
Scan phantom_scan(const PhantomOptions &options);

} // namespace livermark::segmentation
