#pragma once

#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"

/// Bodies of segmentations, for `livermark mesh` and all that takes bodies. The program `livermark-segment` makes them,
/// in a process of its own; where it is not built yet it is built first, and where that cannot be done each says how.
namespace livermark::cli {

inline constexpr int default_tetrahedra = 16000;

/// What `livermark mesh --labels` and `--surfaces` were asked for.
struct SegmentCommand {
    std::string labels{};                ///< file, or folder of a DICOM series
    std::vector<int> liver{}, tumours{}; ///< labels
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

/// What `livermark mesh check` says of a label image, or of a surface: lines of "name value unit".
/// @throws support::InputError
std::string figures_of_labels(const std::string &file);
std::string figures_of_surface(const std::string &file);

/// What `livermark mesh --phantom` was asked for.
struct PhantomCommand {
    std::vector<double> spacing{0.8e-3, 0.8e-3, 3e-3}; ///< [m]
    std::vector<double> turn{0.0, 0.0, 0.0};           ///< rotation vector [rad]
    bool touching = false;
    std::string output; ///< label image
    std::string scan;   ///< scan beside it, if there is to be one
};

/// Writes the label image of the liver that ships, and a scan of it.
/// @throws support::InputError
int make_phantom(const PhantomCommand &command);

/// What a body is made of. Bodies are the same if their content and options are, whatever the files are called.
struct BodySources {
    std::vector<std::string> files; ///< absolute paths, as they were given
    std::string options;            ///< all that decides besides the files
    std::string content;            ///< sixteen digits that stand for the bytes of the files

    bool is_same_body(const BodySources &other) const { return options == other.options && content == other.content; }
};

/// Reads the files of a command: every file of a folder, and the voxels that a header leaves to another file.
/// @throws support::InputError if one of them cannot be read
BodySources sources_of(const SegmentCommand &command);

/// The same as a table of a body file, [image.made_of].
std::string sources_toml(const BodySources &sources);

/// What a body file says that it was made of; nothing if it does not say it.
/// @throws support::InputError if it cannot be read
std::optional<BodySources> sources_in(const std::filesystem::path &body_file);

} // namespace livermark::cli
