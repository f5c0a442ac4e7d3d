#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "meshes/segmentation/images/segmentation.hpp"

namespace livermark::segmentation {

/// The regions of a body as smooth fields on a grid of cubes: what the mesher sees of it, whether it was an image or
/// surfaces before.
struct LabelFields {
    std::array<int, 3> size = {0, 0, 0};    ///< samples along each axis
    double spacing = 0.0;                   ///< [m]
    core::Vector3 low = {0.0, 0.0, 0.0};    ///< place of the first sample, in the axes of the image [m]
    std::vector<std::vector<float>> inside; ///< (R) of (samples), the first axis runs fastest: about 1 well inside the
                                            ///< region, 0 well outside it, about 1/2 on its border; 0 on the
                                            ///< border of the grid
    std::vector<double> volume;             ///< (R) that the region has to have in the end [m^3]
};

/// The share of each region in the surroundings of a sample (a Gaussian whose width goes with the voxels), so that the
/// borders are free of the stairs that voxels make.
/// @param spacing  of the samples [m]; no finer than pays for the tetrahedra that are wanted
LabelFields label_fields(const Segmentation &segmentation, double spacing);

inline constexpr int outside = -1; ///< label of all that is not the body

/// Fields with what makes labels of them: a place is inside the body where the sum of the fields is above a threshold,
/// and there it belongs to the region whose weighted field is largest.
struct LabelDomain {
    LabelFields fields;
    std::vector<float> body;         ///< (samples) sum of the fields
    double threshold = 0.5;          ///< of the sum
    std::vector<double> weight;      ///< (R) of the fields
    std::vector<std::int16_t> label; ///< (samples) region or `outside`
};

/// Threshold and weights with which body and regions have the volumes wanted, as far as counted samples tell.
LabelDomain match_volumes(LabelFields fields);

/// Region at a place of the image's axes [m], between the samples by trilinear interpolation; or `outside`.
int label_at(const LabelDomain &domain, const core::Vector3 &place);

/// Number of labels that may meet at a point for the functions below: two surfaces cross in a curve, three in a point.
inline constexpr int max_labels = 4;
using Levels = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, max_labels - 1, 1>;
using LevelGradients = Eigen::Matrix<double, Eigen::Dynamic, 3, 0, max_labels - 1, 3>;

/// Functions that vanish where several labels meet: for each label but the last, how far it is ahead of the next.
/// @param labels  two to max_labels distinct ones, `outside` first if it is there
/// @return (labels - 1) without unit
Levels level_differences(const LabelDomain &domain, const core::Vector3 &place, const std::vector<int> &labels);

/// @return (labels - 1) x 3, gradient of level_differences [1/m], by central differences
LevelGradients level_gradients(const LabelDomain &domain, const core::Vector3 &place, const std::vector<int> &labels);

/// The part of each gradient that is at right angles to those before it, so that a step along one does not disturb
/// them. Zero where surfaces graze each other, because the curve that they meet in is then anywhere; the surface that
/// comes first, the capsule if it is there, has precedence.
LevelGradients independent_normals(LevelGradients gradients);

/// The nearest place, as far as Newton's steps tell, where level_differences has the given values.
core::Vector3 project_to_levels(const LabelDomain &domain, core::Vector3 place, const std::vector<int> &labels,
                                const Levels &values);

} // namespace livermark::segmentation
