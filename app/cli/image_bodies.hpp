#pragma once

#include <cstdio>
#include <optional>
#include <string>
#include <vector>

/// Bodies of segmentations, for `livermark mesh` and all that takes bodies. The program `livermark-segment` makes them,
/// in a process of its own; where it is not built yet it is built first, and where that cannot be done each says how.
namespace livermark::cli {

inline constexpr int default_tetrahedra = 16000;

/// Options of `livermark mesh --labels` and `--surfaces`.
struct SegmentCommand {
    std::string labels{};                ///< file, or folder of a DICOM series
    std::vector<int> liver{}, tumours{}; ///< labels
    std::vector<std::string> roles{};    ///< NAME=ROLE, of single labels
    std::vector<std::string> surfaces{}; ///< files, the liver first
    std::optional<std::string> unit{};   ///< of the surfaces
    int tetrahedra = default_tetrahedra;
    bool force = false;         ///< over a body that is there
    std::string output{};       ///< the .msh file; the .toml file goes beside it
    std::string command_line{}; ///< kept in the body file
    std::FILE *table = stdout;  ///< where the figures of the mesh go
};

/// Writes <output>.msh and <output>.toml. Where the same command has made them of the same files before, they are left
/// as they are.
/// @return the exit status: 1 if a quality criterion was missed that makes numbers wrong; the mesh is written then as
/// well
/// @throws support::InputError; also if there is another body of this name, and force does not say to write over it
int make_body_of_labels(const SegmentCommand &command);
int make_body_of_surfaces(const SegmentCommand &command);

/// Options of `livermark mesh stiffness`.
struct StiffnessCommand {
    std::string body; ///< a body file
    std::string map;  ///< image of a modulus
    std::string quantity{"shear"}, unit{"kPa"};
    std::string output; ///< the .toml file; the moduli go beside it
};

/// Writes a body file that has the map of stiffness, and the moduli of its tetrahedra beside it.
/// @throws support::InputError
void add_stiffness_map(const StiffnessCommand &command, const std::string &command_line);

/// Options of `livermark mesh vessels`.
struct VesselsCommand {
    std::string labels;                     ///< file, or folder of a DICOM series
    std::vector<std::string> roles;         ///< NAME=ROLE, of single labels
    std::optional<double> largest_radius{}; ///< of the lines [m]
    std::string output;                     ///< the .swc file; that of the image in this folder if empty
};

/// Writes the lines of the vessels of a label image, and prints how large they are and how a body takes them.
/// @throws support::InputError
void write_vessel_lines(VesselsCommand command);

/// Figures of a label image, or of a surface, for `livermark mesh check`: lines of "name value unit".
/// @throws support::InputError
std::string figures_of_labels(const std::string &file);
std::string figures_of_surface(const std::string &file);

/// Options of `livermark mesh --phantom`.
struct PhantomCommand {
    std::vector<double> spacing{0.8e-3, 0.8e-3, 3e-3}; ///< [m]
    std::vector<double> turn{0.0, 0.0, 0.0};           ///< rotation vector [rad]
    bool touching = false, vessels = false;
    std::string output;    ///< label image
    std::string scan;      ///< scan beside it, if there is to be one
    std::string stiffness; ///< the same of a map of its shear modulus
};

/// Writes the label image of the liver that ships, and a scan of it.
/// @throws support::InputError
int make_phantom(const PhantomCommand &command);

/// @return the name without the ending of a label image, that of a folder, or nothing if it is no such name
std::string stem_of_image(const std::string &body);

/// Bodies that are segmentations are meshed first: label images, folders of DICOM slices, and closed surfaces.
/// <output>/<name>.msh and .toml take their place. A body file there that was made of the same content by the same
/// options is used as it is, so that materials put into it stay. Where the name belongs to another body already, say
/// that of another patient or of the segmentation before it was edited, the new one is <name>_<eight digits>.
/// @param bodies        names and files, as behind --body; all surfaces among them are one body, the first the liver
///   and the others its lesions
/// @param command_line  kept in the body files
/// @param force         whether to mesh anew what is there of the same content
/// @return body files in the place of segmentations, the others as they were
/// @throws support::InputError
std::vector<std::string> with_images_meshed(const std::vector<std::string> &bodies, const std::string &output,
                                            const std::string &command_line, bool force);

/// The same where a command has no folder for bodies: they are kept where `livermark run` keeps them by default, so
/// that commands take each other's.
std::vector<std::string> with_images_meshed(const std::vector<std::string> &bodies, const std::string &command_line);

/// The same of one body.
std::string with_image_meshed(const std::string &body, const std::string &command_line);

} // namespace livermark::cli
