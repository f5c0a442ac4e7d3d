#pragma once

#include <string>
#include <vector>

#include "server/sessions/live_body.hpp"

namespace livermark::server {

/// What cuts have left of a body, as a body of its own.
struct CutLiveBody {
    LiveBody left;         ///< its boundary triangles in the order of live::Remains
    std::vector<int> node; ///< (N) of each node: its number in the whole body, ascending
};

/// @param gone  numbers of tetrahedra of the whole body, with commas between them; each once, ascending
/// @throws support::InputError if they are not that, or nothing is left
CutLiveBody cut_live_body(const LiveBody &whole, const std::string &gone);

} // namespace livermark::server
