#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/mesh/plausible_liver.hpp"
#include "core/mesh/tetra_mesh.hpp"

namespace livermark::segmentation {

/// Grid of the voxels of an image. Places in the image are given in metres along its axes from the centre of the
/// first voxel; places in the world are LPS as in DICOM (x to the patient's left, y posterior, z superior).
struct ImageGrid {
    std::array<int, 3> size = {0, 0, 0};                            ///< voxels along each axis
    core::Vector3 spacing = {0.0, 0.0, 0.0};                        ///< between voxel centres [m]
    core::Vector3 origin = {0.0, 0.0, 0.0};                         ///< centre of the first voxel in the world [m]
    Eigen::Matrix3d direction = Eigen::Matrix3d::Identity().eval(); ///< columns: the image's axes, orthonormal;
                                                                    ///< determinant -1 if they are left-handed
};

std::size_t num_voxels(const ImageGrid &grid);

double voxel_volume(const ImageGrid &grid); ///< [m^3]

/// Place in the world [m] of a place in the image [m].
core::Vector3 to_world(const ImageGrid &grid, const core::Vector3 &place);

/// An image whose values are numbers of labels, 0 for the background.
struct LabelImage {
    std::string name; ///< of the file or folder
    ImageGrid grid;
    std::vector<std::uint16_t> label;         ///< (num_voxels) the first axis runs fastest
    std::map<int, std::string> label_names{}; ///< of segments, where the file has them
    std::map<int, core::SegmentCode> label_codes{};
    std::string patient_position{};     ///< how the patient lay, in DICOM's words such as HFS; empty if nobody says
    std::vector<std::string> remarks{}; ///< a sentence for what the file leaves in doubt
};

/// An image whose values are not known to be anything yet.
struct ScalarImage {
    std::string name; ///< of the file or folder
    ImageGrid grid;
    std::vector<float> value;           ///< (num_voxels) the first axis runs fastest
    std::vector<std::string> remarks{}; ///< a sentence for what the file leaves in doubt
};

/// A scan, such as a computed tomography.
struct Scan {
    ImageGrid grid;
    std::vector<std::int16_t> grey_value; ///< (num_voxels) [HU] the first axis runs fastest
};

inline constexpr int phantom_liver_label = 1;
inline constexpr int phantom_first_tumour_label = 2; ///< of the largest lesion; the others follow
inline constexpr int phantom_hepatic_label = 8;      ///< of the hepatic veins, where it has vessels
inline constexpr int phantom_portal_label = 9;

/// Options of the phantom: how it was scanned.
struct PhantomOptions {
    core::Vector3 spacing = {0.8e-3, 0.8e-3, 3e-3}; ///< of the voxels [m]
    core::Vector3 turn = {0.0, 0.0, 0.0};           ///< rotation vector of the image's axes against the patient's [rad]
    bool touching = false; ///< the second lesion moved to the capsule, and the fifth to the first
    bool vessels = false;  ///< with trunks of hepatic and portal veins, 6 to 12 mm across, and names of all labels
};

/// The liver that ships with its six lesions, as somebody would have segmented it: a voxel is what lies at its centre.
LabelImage phantom_labels(const PhantomOptions &options);

/// A scan of it: grey values of a portal venous phase (liver 110 HU, lesions 70 HU, vessels 170 HU, fat around it
/// -90 HU), blurred over a voxel and with noise of 12 HU; the same every time.
Scan phantom_scan(const PhantomOptions &options);

/// Its shear modulus [Pa] as an elastography without noise would show it, 0 outside and in vessels: parenchyma of 5 kPa
/// / 2.9 times e^s with a smooth s, the sum of three waves of 60 to 95 mm whose mean square is 0.06, so that it varies
/// by a quarter; lesions of 50 kPa / 2.9.
Scan phantom_stiffness(const PhantomOptions &options);

/// Role that somebody gives to labels of an image.
struct ChosenRole {
    std::string segment; ///< name of a segment, or a label
    core::SegmentRole role = core::SegmentRole::other;
    std::string region{}; ///< of a vessel
};

/// Reads NAME=ROLE, with a role of liver, tumour, vessel, vessel_hepatic, vessel_portal, vessel_artery, cyst,
/// gallbladder and ignore.
/// @throws support::InputError
ChosenRole chosen_role(const std::string &words);

/// Labels of an image that make the body. Where neither liver nor tumours are given the codes and names of its segments
/// decide, and where it has none the smallest label is the liver, and every other one a tumour's.
struct LabelChoice {
    std::vector<int> liver; ///< its tissue
    std::vector<int> tumours;
    std::vector<ChosenRole> roles{}; ///< of single labels, whatever the names say
};

/// Labels that are in an image, by the roles that their codes and names give them.
std::map<core::SegmentRole, std::vector<int>> labels_by_role(const LabelImage &image);

/// The volume of the labels that make the liver and its lesions: those that are chosen, else those with such names,
/// else all.
/// @return [m^3]
/// @throws support::InputError  as choose_labels()
double labelled_volume(const LabelImage &image, const LabelChoice &choice);

/// A liver in one piece without cavities, its lesions and its vessels, in voxels.
struct Segmentation {
    ImageGrid grid;
    std::vector<std::uint8_t> region;      ///< (num_voxels) 0 outside the body, else 1 + index into region_names
    std::vector<std::string> region_names; ///< (R) "parenchyma", then "tumour_1" ... and "cyst_1" ..., largest first,
                                           ///< then vessels and an enclosed gallbladder
    std::vector<std::string> remarks;      ///< a sentence for all that was left out, filled or taken for something else
    bool is_lps_by_header = false;         ///< whether the header of its file says where left, back and head are
    std::string patient_position{};        ///< LabelImage::patient_position
};

/// The volume of the voxels of each region.
/// @return (R) [m^3]
std::vector<double> region_volumes(const Segmentation &segmentation);

/// A vessel is a region where it is as thick as this, in edges of tetrahedra: thinner ones would be a chain of
/// tetrahedra with all nodes on the border.
inline constexpr double edges_across_vessel = 1.5;

/// Picks the body out of an image: the largest piece of liver, tumours and cysts together, with the vessels between;
/// other pieces are left out, cavities become parenchyma, and each connected piece of a tumour or a cyst is a lesion of
/// its own, unless it is smaller than a tetrahedron, in which case it becomes parenchyma. The parts of vessels that are
/// thick enough (edges_across_vessel) are a region for each kind; what is thinner becomes parenchyma, and what reaches
/// out of the liver is left out. A gallbladder is left out unless the liver encloses it. Nothing of this goes unsaid.
/// @param tetrahedron  volume of one in the mesh that is wanted [m^3]
/// @throws support::InputError  if a label or name that was asked for is not in the image, if segments have names and
///                           none is that of a liver, if nothing is left, or if there are more regions than a body can
///                           have (255)
Segmentation choose_labels(const LabelImage &image, const LabelChoice &choice, double tetrahedron);

/// Reads a label image: NIfTI (.nii, .nii.gz, .hdr with .img), NRRD (.nrrd, .nhdr), MetaImage (.mha, .mhd), a DICOM
/// segmentation object (see read_dicom_segmentation()), or a folder with one DICOM series (ITK, which turns NIfTI's RAS
/// into LPS). Values within a thousandth of whole numbers are whole. Readers of others run in a process of their own,
/// which may fail on a damaged file.
/// @return also the names of segments, and remarks on what the file leaves in doubt
/// @throws support::InputError with the file, what is wrong and a remedy: no such format, not three-dimensional,
/// several
///         values per voxel, values that are no labels, sheared axes, absurd spacing, more in the header than in the
///         file, damaged data
LabelImage read_label_image(const std::filesystem::path &file);

/// Reads an image of any values in the same formats, but for a DICOM segmentation object.
/// @throws support::InputError as read_label_image()
ScalarImage read_scalar_image(const std::filesystem::path &file);

/// Writes a label image in the format that the name asks for: .nii, .nii.gz, .nrrd or .mha. NRRD keeps the names of the
/// labels as 3D Slicer does.
/// @throws support::InputError if the name asks for another one, or for one without names where labels have some, or
/// nothing can be put there
void write_label_image(const std::filesystem::path &file, const LabelImage &image);

/// Writes a scan in the same way.
void write_scan(const std::filesystem::path &file, const Scan &scan);

} // namespace livermark::segmentation
