#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/cli/image_bodies.hpp"
#include "core/mesh/tetra_mesh.hpp"

/// Sources of bodies, and what is shown of them.
namespace livermark::cli {

/// Sources of a body. Bodies are the same if their content and options are, whatever the files are called.
struct BodySources {
    std::vector<std::string> files; ///< absolute paths, as they were given
    std::string options;            ///< all that decides besides the files
    std::string content;            ///< sixteen digits that stand for the bytes of the files

    bool is_same_body(const BodySources &other) const { return options == other.options && content == other.content; }
};

/// Sources of a command: every file of a folder, and the voxels that a header leaves to another file.
/// @throws support::InputError if one of them cannot be read
BodySources sources_of(const SegmentCommand &command);

/// The same as a table of a body file, [image.made_of].
std::string sources_toml(const BodySources &sources);

/// Sources as a body file has them; nothing if it does not say them.
/// @throws support::InputError if it cannot be read
std::optional<BodySources> sources_in(const std::filesystem::path &body_file);

/// Places of the .toml of the body of a result file: beside the folder of its results, where `livermark run` puts
/// it, or in the folder that is looked at. Nothing for a body with a name that no file has.
std::vector<std::filesystem::path> body_files_of(const std::filesystem::path &result, const std::string &body,
                                                 const std::filesystem::path &folder);

/// JSON of three slices of the label image that a body was made of, as livermark.report.slices reads them; empty where
/// the body file names no image, or the image went or has changed since, or `livermark-segment` is not built.
/// @param body_file  a .toml, which may be missing
/// @param at         place that the slices go through [m]
/// @throws support::InputError if the image cannot be read
std::string slices_of_image(const std::filesystem::path &body_file, const core::Vector3 &at);

/// JSON of all voxels around the body in the label image that it was made of, as `livermark-segment voxels` writes it.
/// @param body_files  of which the first that is there counts
/// @throws support::InputError  with why there are none: no such body file, made of something else, the image went, has
///   changed since or is too large, or `livermark-segment` is not built
std::string voxels_of_image(const std::vector<std::filesystem::path> &body_files);

} // namespace livermark::cli
