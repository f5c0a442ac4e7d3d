#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/load_case.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "core/problem.hpp"

/// Names and codes of parts of the body, as segmentations and meshes have them: one table for all.
namespace livermark::core {

/// Part that a segment of an image, or a region of a mesh, has in a liver.
enum class SegmentRole {
    liver,       ///< its tissue, all or a lobe or a segment of it
    lesion,      ///< tumour and the like, unless it is said to be of another organ
    cyst,        ///< the same of a fluid in a thin wall
    vessel,      ///< vessels and ducts
    gallbladder, ///< beside the liver, and no tissue of it
    other,       ///< everything else that has a name
    unnamed,     ///< a number, or a word that says nothing, such as "Segment_1"
};

/// Vessels that names tell apart.
enum class VesselKind {
    any,     ///< vessels and ducts of the liver, or nothing says whose
    hepatic, ///< veins from the liver to the vena cava
    portal,  ///< veins to the liver
    artery,
    beside, ///< vena cava, aorta, and those of other organs, which may touch the liver but lie beside it
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

/// Kind of a vessel by the words of its code, or by its name where they do not say it.
VesselKind kind_of_vessel(const std::string &name, const SegmentCode &code);

/// Whether what somebody gives as a liver, a tissue or a load can be one. Every way in asks here: label images,
/// surfaces, meshes, Python.

/// Volume of an adult's liver, from after a resection to enlarged [L], and a usual one.
inline constexpr double smallest_liver = 0.5, usual_liver = 1.5, largest_liver = 4.0;
/// Longest side of a body that can be an organ [m].
inline constexpr double largest_organ = 2.0;
/// Nearer to 1/2 the volume is so much stiffer than the shape that searches for an equilibrium do not end in double
/// precision.
inline constexpr double largest_poisson_ratio = 0.49999;

/// A sentence for each thing that speaks against a body being an adult's liver in metres: its volume, and lesions that
/// are larger than its other tissue.
/// @param volume   of liver and lesions [m^3]
/// @param lesions  of each [m^3]
std::vector<std::string> doubts_about_liver(double volume, std::span<const double> lesions);

/// The same of a mesh, whose lesions are regions with names of tumours and cysts.
std::vector<std::string> doubts_about_liver(const TetraMesh &mesh);
/// Doubts about its lesions alone.
std::vector<std::string> doubts_about_lesions(const TetraMesh &mesh);

/// A sentence if a body in metres is larger than any organ, as one in millimetres is, or smaller than any sample of
/// one.
std::vector<std::string> doubts_about_unit(const std::vector<Vector3> &points);

/// A sentence for each material whose density or Young's modulus no tissue or phantom of one has, as g/cm^3 and kPa
/// make it.
/// @param names  of the regions of the materials
std::vector<std::string> doubts_about_materials(std::span<const Material> materials,
                                                std::span<const std::string> names);

/// A sentence for each place of a load case with a traction, force or displacement that no hand or instrument gives a
/// body of this size, and for an acceleration that none survives. Loads that are to be scaled are not looked at.
std::vector<std::string> doubts_about_loads(const LoadCase &load_case, const TetraMesh &mesh);

/// A sentence if the noise of a measurement of displacements is larger than a tenth of the largest that was measured,
/// or than a centimetre.
/// @param noise    root mean square length [m]
/// @param largest  displacement that was measured [m]
std::vector<std::string> doubts_about_noise(double noise, double largest);

/// Two tetrahedra that no way over faces joins; nothing if all are joined. A part that hangs on an edge or a node
/// swings about it, and finite elements have no reference for it.
std::optional<std::pair<std::size_t, std::size_t>> apart_by_faces(std::span<const std::array<int, 4>> tetrahedra);

} // namespace livermark::core
