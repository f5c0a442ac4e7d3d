#pragma once

#include <string>
#include <vector>

namespace livermark::cli {

/// @return the name without the ending of a label image, that of a folder, or nothing if it is no such name
std::string stem_of_image(const std::string &body);

/// Bodies that are segmentations are meshed first: label images, folders of DICOM slices, and closed surfaces.
/// <output>/<name>.msh and .toml take their place. A body file there that was made of the same content by the same
/// options is used as it is, so that materials put into it stay. Where the name belongs to another body already, say
/// that of another patient or of the segmentation before it was edited, the new one is <name>_<eight digits>.
/// @param bodies        names and files, as behind --body; all surfaces among them are one body, the first the liver
/// and
///                      the others its lesions
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
