#pragma once

#include <optional>
#include <string>
#include <vector>

/// What `livermark-segment` does: bodies of segmentations, for `livermark`, which starts it.
namespace livermark::segmentation {

struct BodyCommand {
    std::string labels{};                ///< file, or folder of a DICOM series
    std::vector<int> liver{}, tumours{}; ///< labels
    std::vector<std::string> surfaces{}; ///< files, the liver first
    std::optional<std::string> unit{};   ///< of the surfaces
    int tetrahedra = 0;
    std::string mesh{};         ///< the .msh file; the .toml file goes beside it
    std::string made_of{};      ///< table of the body file
    std::string command_line{}; ///< kept in the body file
};

/// Writes the mesh and the body file; remarks go to standard error, the figures of the mesh to standard output.
/// @return the exit status: 1 if a quality criterion was missed that makes numbers wrong; the mesh is written then as
/// well
/// @throws support::InputError
int make_body_of_labels(const BodyCommand &command);
int make_body_of_surfaces(const BodyCommand &command);

/// What `livermark mesh check` says of a label image, or of a surface: lines of "name value unit".
/// @throws support::InputError
std::string figures_of_labels(const std::string &file);
std::string figures_of_surface(const std::string &file);

struct PhantomCommand {
    std::vector<double> spacing, turn; ///< [m], rotation vector [rad]
    bool touching = false;
    std::string output; ///< label image
    std::string scan;   ///< scan beside it, if there is to be one
};

/// Writes the label image of the liver that ships, and a scan of it.
/// @throws support::InputError
int make_phantom(const PhantomCommand &command);

} // namespace livermark::segmentation
