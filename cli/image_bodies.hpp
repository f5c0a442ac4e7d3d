#pragma once

#include <string>
#include <vector>

namespace livermark::cli {

/// @return the name without the ending of a label image, that of a folder, or nothing if it is no such name
std::string stem_of_image(const std::string &body);

/// Bodies that are segmentations are meshed first: label images, folders of DICOM slices, and closed surfaces.
/// <output>/<name>.msh and .toml take their place. A body file that is there already is used as it is, so that
/// materials put into it stay.
/// @param bodies        names and files, as behind --body; all surfaces among them are one body, the first the liver
/// and
///                      the others its lesions
/// @param command_line  kept in the body files
/// @param force         whether to write over a body file
/// @return body files in the place of segmentations, the others as they were
/// @throws support::InputError
std::vector<std::string> with_images_meshed(const std::vector<std::string> &bodies, const std::string &output,
                                            const std::string &command_line, bool force);

} // namespace livermark::cli
