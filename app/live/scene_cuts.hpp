#pragma once

#include <memory>
#include <span>
#include <vector>

#include "app/live/parameters.hpp"
#include "app/live/scene.hpp"
#include "msm/cutting/cut_parts.hpp"

/// Springs of what cuts have left, fitted as those of a body of its own: their frequencies, and what follows from them.
namespace livermark::live {

struct FittedRest {
    msm::PartOfBody part;         ///< at rest
    std::vector<int> tetrahedron; ///< (M) which of the whole body these are
    msm::MassSprings springs;
    Stepping stepping; ///< in numbers of the part
};

/// @param body        whole, of the chosen material
/// @param is_gone     shape (M)
/// @param conditions  of the nodes of the whole body
/// @throws support::InputError if the time step is too long for what is left
FittedRest fit_rest(const core::Body &body, const std::vector<char> &is_gone, const msm::NodalConditions &conditions,
                    const Settings &settings);

/// In numbers of the whole body.
msm::MassScaling scaling_of_whole(const FittedRest &rest);

/// watched_volumes() in numbers of the whole body of so many tetrahedra; none of what is gone.
std::vector<double> watched_of_whole(const FittedRest &rest, const Stepping &stepping, std::size_t num_tetrahedra);

/// The critical time step of what is around a wound, with all else constrained, of symplectic Euler at rest [s]:
/// infinity if nothing there moves. Steps below this and below the critical one before the cut are stable after it.
/// Nodes whose masses are scaled count as constrained: they are heavy. Springs of laws that look at the whole body are
/// those of the part around the wound.
/// @param body       whole, of the chosen material
/// @param is_gone    shape (M), with the new cut
/// @param gone       tetrahedra that the new cut takes
/// @param scaling    of the masses that stay scaled, in numbers of the whole body
double critical_step_around(const core::Body &body, const std::vector<char> &is_gone, std::span<const int> gone,
                            msm::NodalConditions conditions, const msm::MassScaling &scaling, const Settings &settings);

struct Scene::Prepared {
    core::Body body; ///< of the chosen material, whole
    msm::MassSprings parts;
    Settings settings;
    Stepping stepping; ///< of the whole body, or of the rest in its numbers
    /// Remains that cuts had left when this was chosen; null if nothing had been cut.
    std::shared_ptr<const FittedRest> rest;
    std::size_t num_cuts = 0; ///< that had been made by then
};

/// Into how many parts a step has to be divided so that none is longer.
int num_parts_of(double time_step, double longest);

} // namespace livermark::live
