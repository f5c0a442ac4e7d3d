#pragma once

#include <filesystem>
#include <vector>

#include "core/load_case.hpp"
#include "core/problem.hpp"
#include "core/tool/needle/needle.hpp"

namespace livermark::load_cases {

/// Reads the needles of a load case, whose lengths are in its 'unit', and puts them on a body. Its conditions hold the
/// body, and nothing else acts.
///
///     [[needle]]
///     name = "to the largest"        # in tables and files
///     entry = "anterior"             # a patch: of its surface the point that is nearest to the target; or
///                                    # [x, y, z] [m], moved to the nearest point of the surface
///     target = "tumour_1"            # the centroid of a region, or [x, y, z] [m]; or instead
///     depth = 0.06                   # [m], below the middle of the patch, against its normal there
///     diameter = 0.00127             # [m]
///     spread = 0.006                 # [m], radius of the places that forces are spread over: that of the needle or
///                                    # more, and no less than core::smallest_spread()
///     toughness = 164.0              # [J/m^2], see core::Needle
///     friction = 20.0                # [N/m]
///     puncture_force = 1.4           # [N]; what tearing takes if it is left out: a nick was made first
///     step = 0.0005                  # [m], may be left out
///
/// @param toml_file   the load case
/// @param load_case   the same, put on the mesh of the body
/// @return one or more
/// @throws support::InputError with file, line and remedy: nothing is driven in, numbers out of range, an entry that is
///   held or no surface, a target outside, a way that leaves the body, two needles of one name or one way; NotOnBody
///   for a patch or region that this body lacks
std::vector<core::Needle> read_needles(const std::filesystem::path &toml_file, const core::Body &body,
                                       const core::LoadCase &load_case);

} // namespace livermark::load_cases
