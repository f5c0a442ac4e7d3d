#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cli/segment.hpp"

namespace livermark::cli {

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
