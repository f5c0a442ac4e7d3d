#pragma once

#include <limits>
#include <string>
#include <vector>

/// Lines of the vessels of a label image, for `livermark mesh vessels`.
namespace livermark::segmentation {

struct VesselCommand {
    std::string labels{};                                            ///< file, or folder of a DICOM series
    std::vector<std::string> roles{};                                ///< NAME=ROLE
    double largest_radius = std::numeric_limits<double>::infinity(); ///< of the lines [m]
    std::string output{};                                            ///< the .swc file
};

/// Writes the lines of all vessels of the liver, each label a tree of its own, in metres; remarks go to standard error,
/// what was made to standard output.
/// @return the exit status
/// @throws support::InputError where there is no such label, or no line
int write_vessel_lines(const VesselCommand &command);

} // namespace livermark::segmentation
