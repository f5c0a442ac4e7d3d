#pragma once

#include <memory>

#include "live/cutting/fitted_rest.hpp"
#include "live/scene.hpp"

namespace livermark::live {

struct Scene::Prepared {
    core::Body body; ///< of the chosen material, whole
    msm::MassSprings parts;
    Settings settings;
    Stepping stepping; ///< of the whole body, or of the rest in its numbers
    /// What cuts had left when this was chosen; null if nothing had been cut.
    std::shared_ptr<const FittedRest> rest;
    std::size_t num_cuts = 0; ///< that had been made by then
};

/// Into how many parts a step has to be divided so that none is longer.
int num_parts_of(double time_step, double longest);

} // namespace livermark::live
