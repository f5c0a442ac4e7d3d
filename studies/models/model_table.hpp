#pragma once

#include <array>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/model.hpp"
#include "fem_reference/linear/elastic_system.hpp"
#include "msm/integrator.hpp"

namespace livermark::msm {
struct MassSprings;
}

namespace livermark::models {

/// The names of a reference and of the same on finer meshes, see core::Role; empty where there is none.
struct ReferenceNames {
    std::string on_mesh;
    std::string refined;
};

/// Models that others are compared with: at rest, and where something moves in time.
ReferenceNames static_reference(core::Regime regime);
ReferenceNames moving_reference(core::Regime regime);

/// The one that a mass-spring model has to beat.
std::string baseline_name();

/// Ways in which mass-spring models find where they come to rest.
enum class EquilibriumMethod { newton, relaxation };

/// Choices of a user about models.
struct ModelOptions {
    fem_reference::SolverChoice fem_solver = fem_reference::SolverChoice::automatic;
    EquilibriumMethod equilibrium = EquilibriumMethod::newton;
    livermark::msm::TimeStepping time_stepping; ///< of mass-spring models, where something depends on time
    std::shared_ptr<const core::CalibratedSprings>
        calibration; ///< of calibrated_nodal_volume, which is not there without
    /// More values of constants of models, by the key of swept_constants: each is a model of its own, beside the one
    /// that ships.
    std::map<std::string, std::vector<double>> sweeps;

    /// None where a constant is not swept.
    std::vector<double> sweep_of(std::string_view constant) const;
};

/// A constant of which a run may have more values.
struct SweptConstant {
    std::string_view key; ///< <model>.<constant>
    double largest;       ///< values are above 0 and up to this
};

/// Parts of the stiffness that stay inside tetrahedra, and the weight of forces against that of isotropy in the fit of
/// patch.
inline constexpr std::array<SweptConstant, 3> swept_constants{
    {{"nodal_neo_hookean.a", 1.0}, {"nodal_springs.a", 1.0}, {"patch_nodal_volume.w", 100.0}}};

/// The name of the model with another value, such as nodal_springs_a_0_25: a name holds no '.'.
std::string swept_name(std::string_view constant, double value);

/// Models that come from one adapter. One file each in families/, named as the family.
struct ModelFamily {
    std::string name;                                         ///< the file stem; set by the table
    std::vector<core::Model> (*models)(const ModelOptions &); ///< at least one
};

/// Every family of families/, in alphabetical order.
std::span<const ModelFamily> all_families();

/// Every model of every family. Models of one call may share what they keep from one problem to the next, so they are
/// for one thread.
std::vector<core::Model> all_models(const ModelOptions &options = {});

using MakeMassSprings = std::function<msm::MassSprings(const core::Body &)>;

/// A model that comes to rest and moves in time as the options say.
core::Model mass_spring_model(std::string name, std::string summary, std::string source, const MakeMassSprings &make,
                              const ModelOptions &options);

/// Whether a model is one of mass_spring_model().
bool has_springs(const core::Model &model);

/// The springs of a model on a body, as it solves and moves with them; nothing of a model that is none of
/// mass_spring_model().
std::optional<msm::MassSprings> springs_of(const core::Model &model, const std::shared_ptr<const core::Body> &body);

} // namespace livermark::models
