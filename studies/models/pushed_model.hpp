#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "core/mesh/places.hpp"
#include "core/model.hpp"
#include "core/tool/needle/needle.hpp"
#include "fem_reference/hyperelastic/hyperelasticity.hpp"

namespace livermark::models {

/// A model in which a needle may move the tissue far.
struct PushedModel {
    int num_meshes = 1; ///< the one of the body, and those of a model that refines
    /// @param mesh   0, that of the body, to num_meshes - 1, the finest near the places
    /// @param known  compliance of such a body on another mesh, from which a search may begin as well; or nullptr
    /// @throws support::InputError if the load case leaves the body free to move
    std::function<std::unique_ptr<core::PushedBody>(const core::Problem &, std::span<const core::InteriorPlace>,
                                                    int mesh, const Eigen::MatrixXd *known)>
        prepare;
};

/// @return nothing for a model that cannot: linear elements, whose compliance is all there is to know, and methods that
///   know no forces on places
std::optional<PushedModel> pushed_model(const core::Model &model);

/// Law and discretisation of a model of hyperelastic elements.
struct HyperelasticElements {
    std::string_view name, summary;
    std::string_view law; ///< in fem_reference/hyperelastic/materials/
    hyperelastic::Discretisation discretisation;
    bool is_refined = false; ///< whether it also goes to finer meshes
    core::Role at_rest = core::Role::candidate, in_motion = core::Role::candidate;
};

/// @return nothing for the name of another model
std::optional<HyperelasticElements> hyperelastic_elements(std::string_view name);

} // namespace livermark::models
