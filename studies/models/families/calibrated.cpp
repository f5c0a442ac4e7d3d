#include <fmt/format.h>

#include "msm/elastic_body.hpp"
#include "msm/springs/spring_network.hpp"
#include "studies/models/mass_spring_model.hpp"

namespace livermark::models::families {

namespace {

core::SpringNetwork springs_of(const core::CalibratedSprings &calibration, const core::Body &body) {
    core::check_fit(calibration, body);
    return {.node_mass = livermark::msm::lumped_masses(body),
            .edges = calibration.edges,
            .stiffness = calibration.stiffness,
            .rest_length = calibration.rest_length};
}

} // namespace

/// Springs whose stiffnesses were fitted to solutions of finite elements on this very mesh, and the nodal volume that
/// they were fitted beside. It is there for whoever has such stiffnesses.
ModelFamily calibrated() {
    return {.name = {}, .models = [](const ModelOptions &options) -> std::vector<core::Model> {
                const auto calibration = options.calibration;
                if (!calibration)
                    return {};
                const auto &term = livermark::msm::find_volume_term("nodal_volume");
                auto model = mass_spring_model(
                    "calibrated_nodal_volume",
                    fmt::format("springs fitted to finite elements on this mesh, with {}", term.summary),
                    fmt::format("`python3 -m livermark.calibration`; {}", term.source),
                    [calibration, term](const core::Body &body) {
                        return livermark::msm::springs_with_volume(body, springs_of(*calibration, body), term);
                    },
                    options);
                model.check = [calibration, of_springs = model.check](const core::Problem &problem) {
                    core::check_fit(*calibration, *problem.body);
                    of_springs(problem);
                };
                return {model};
            }};
}

} // namespace livermark::models::families
