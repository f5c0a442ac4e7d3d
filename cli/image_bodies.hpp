#pragma once

#include <string>
#include <vector>

namespace livermark::cli {

/// Bodies that are label images, or folders of DICOM slices, are meshed first: <output>/<name>.msh and .toml take their
/// place. A body file that is there already is used as it is, so that materials put into it stay.
/// @param bodies        names and files, as behind --body
/// @param command_line  kept in the body files
/// @return body files in the place of images, the others as they were
/// @throws support::InputError
std::vector<std::string> with_images_meshed(std::vector<std::string> bodies, const std::string &output,
                                            const std::string &command_line);

} // namespace livermark::cli
