#pragma once

#include <string>

/// Names and codes of parts of the body, as segmentations and meshes have them: one table for all.
namespace livermark::core {

/// Part that a segment of an image, or a region of a mesh, has in a liver.
enum class SegmentRole {
    liver,   ///< its tissue, all or a lobe or a segment of it
    lesion,  ///< tumour, cyst and the like, unless it is said to be of another organ
    vessel,  ///< vessels and ducts
    other,   ///< everything else that has a name
    unnamed, ///< a number, or a word that says nothing, such as "Segment_1"
};

/// Coded concept of a segment in DICOM and 3D Slicer.
struct SegmentCode {
    std::string type{};    ///< value in SNOMED CT, such as 108369006, or in SNOMED RT, such as M-8FFFF
    std::string meaning{}; ///< words that stand beside it
    std::string region{};  ///< words for the organ that a lesion lies in, if the file has them
};

/// Whole phrases are compared: "liver_right_lobe" is liver; "Liver bed", "Non-liver" and "liver vessels" are not.
SegmentRole role_of_name(const std::string &name);

/// The code decides, then the words that stand beside it, then the name that somebody gave.
SegmentRole role_of_segment(const std::string &name, const SegmentCode &code);

} // namespace livermark::core
