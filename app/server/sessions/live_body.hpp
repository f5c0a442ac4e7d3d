#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/server/session.hpp"
#include "core/problem.hpp"

/// Common part of the sessions of the live page: the body they are about, and what it is made of.
namespace livermark::server {

struct LiveBody {
    std::string file;                       ///< as the page named it, for messages
    std::shared_ptr<const core::Body> body; ///< of the result file
    /// Constrains the facets on which the load case of the file prescribes no displacement in all three components, as
    /// one constraint, and nothing else: the others are free, and nothing pulls. Its foundation bears what is free.
    core::LoadCase constrained;
};

/// Reads the result file that a query names as `file=<path>`, a path of the server's list.
/// @param folder  that is served; absolute, without symlinks and dots
/// @throws support::InputError if the server does not show such a file, if it is damaged, or if no facet is constrained
LiveBody open_live_body(const std::filesystem::path &folder, const Fields &query);

/// A foundation on other facets.
/// @param facets  shape (T) number of each among those that it is on now, -1 where it was none of them
/// @return nothing if it bears none of these
std::optional<core::Foundation> foundation_on(std::optional<core::Foundation> foundation,
                                              const std::vector<int> &facets);

struct LiveMaterial {
    double young_modulus; ///< of the region with the largest volume [Pa]
    double poisson_ratio; ///< of all regions
};

/// Reads `young_modulus=<Pa>&poisson_ratio=<nu>`. Other names are left alone.
/// @throws support::InputError unless they are in [1, 1e9] and [0, 0.49]
LiveMaterial live_material(const Fields &message);

} // namespace livermark::server
