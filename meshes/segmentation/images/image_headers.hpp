#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "meshes/segmentation/images/segmentation.hpp"

namespace livermark::segmentation {

/// A piece of a header without spaces and ends of lines around it.
std::string trimmed(const std::string &text);

/// NIfTI and MetaImage files that were cut off come out of ITK with the rest as zeros: a liver without its top. Does
/// the file hold as many bytes of voxels as its header says? Formats of which ITK takes care itself pass.
/// A pattern of names that printf cannot be given is refused as well.
/// @param data_bytes  of the voxels
/// @throws support::InputError
void check_all_there(const std::filesystem::path &file, double num_voxels, double data_bytes);

/// Are the voxels of a NIfTI header in two files (.hdr, .img) there?
/// @throws support::InputError
void check_voxels_beside(const std::filesystem::path &file);

/// Headers of NRRD and MetaImage may name files of voxels: devices and pipes among them never end. Nor, nearly, does
/// MetaIO with absurdly many dimensions.
/// @throws support::InputError for what is no plain file or not there, and for a number of dimensions that cannot be
void check_text_of_header(const std::filesystem::path &file);

/// The same for the pixels of a DICOM file, of which GDCM makes up what is not there.
/// @param data_bytes  length of the pixel data element
/// @throws support::InputError
void check_dicom_pixels(const std::filesystem::path &file, std::size_t data_bytes);

/// A NIfTI-1 header's words on voxels and their place: https://nifti.nimh.nih.gov/nifti-1/
struct NiftiHeader {
    bool is_swapped = false; ///< whether the other byte order wrote it
    bool is_nifti = true;    ///< not its forerunner Analyze 7.5, which has no place for axes
    std::array<int, 3> size = {0, 0, 0};
    double metres_per_unit = 1e-3; ///< of all lengths below, which are in mm where the header says no unit
    bool has_floats = false;       ///< whether its voxels are stored in floating point
    int bits_per_voxel = 0;        ///< as they are stored, whatever a slope makes of them
    double data_offset = 0.0;      ///< [byte]
    int qform_code = 0;            ///< 0 if it says nothing
    int sform_code = 0;
    Eigen::Vector3d spacing = {1.0, 1.0, 1.0}; ///< between voxels along the axes, of which the qform is made
    Eigen::Matrix3d sform = Eigen::Matrix3d::Identity().eval(); ///< columns: from voxel to voxel along each axis
    Eigen::Matrix3d qform = Eigen::Matrix3d::Identity().eval(); ///< columns: the axes, of length 1
    Eigen::Vector3d sform_origin = {0.0, 0.0, 0.0};             ///< centre of the first voxel; RAS, as the forms are
    Eigen::Vector3d qform_origin = {0.0, 0.0, 0.0};
};

/// Whether a number in floating point is finite, by the bytes that a file has of it. ITK reads what is not as 0.
/// @param bytes  4 or 8
bool is_finite(std::span<const char> bytes, bool is_swapped);

/// @return nothing if the file has no such header, or one of NIfTI-2
std::optional<NiftiHeader> read_nifti_header(const std::filesystem::path &file);

/// Whether a file has a header of NIfTI-2, which ITK does not read.
bool is_nifti_2(const std::filesystem::path &file);
/// Copies such a file with the header that NIfTI-1 has for it; the voxels of a pair stay where they are.
/// @throws support::InputError if NIfTI-1 cannot hold it
void write_as_nifti_1(const std::filesystem::path &file, const std::filesystem::path &to);

/// Voxels may be in a file of their own: NAME.hdr and NAME.img, or NAME.img.gz, in any case.
/// @return the header where the voxels are given, the file itself otherwise
std::filesystem::path header_of_pair(const std::filesystem::path &file);
/// @return the voxels that a .hdr belongs to; nothing if they are not beside it
std::optional<std::filesystem::path> voxels_of_pair(const std::filesystem::path &header);

/// Names of labels in an extension of the header, which Connectome Workbench and TotalSegmentator write: an element
/// Label of XML for each, with its number as Key and its name as CDATA.
std::map<int, std::string> nifti_label_names(const std::filesystem::path &file, const NiftiHeader &header);

/// A sentence if both forms are there and give the voxels different sizes.
std::vector<std::string> doubts_about_forms(const NiftiHeader &header);

/// Degrees by which the pair of axes that is farthest from a right angle misses it, and a clause that names the pair.
struct AxesOff {
    double degrees = 0.0;
    std::string text;
};
AxesOff off_right_angles(const Eigen::Matrix3d &axes);

/// Headers with few digits have axes that are not quite at right angles, which ITK refuses. Copies the file with the
/// nearest axes that are.
/// @param to  a .nii file
void write_with_right_angles(const std::filesystem::path &file, const NiftiHeader &header,
                             const std::filesystem::path &to);

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
