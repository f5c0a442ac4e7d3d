#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/problem.hpp"

namespace livermark::studies {

/// What may differ from a body and a load case as their files have them. Values that are not set stay as they are.
struct Patient {
    std::optional<double> young_modulus{};     ///< of the first region [Pa]; others but tumours keep their ratio to it
    std::optional<double> poisson_ratio{};     ///< of all regions
    std::optional<double> tumour_contrast{};   ///< Young's modulus of tumours over that of the first region
    std::optional<double> density{};           ///< of all regions [kg/m^3]
    std::optional<double> held_share{};        ///< part of the area of the held facets that stays held, in (0, 1]
    std::optional<double> support_stiffness{}; ///< see with_soft_support() [Pa/m]
    std::optional<Eigen::Vector2d> tool_offset{}; ///< see with_tool_moved() [m]
};

/// The regions whose Young's modulus is above that of the first one, as they are in the files; ascending.
std::vector<int> tumour_regions(const core::Body &body);

/// The facets that hold: all components are prescribed to be zero. Ascending.
std::vector<int> held_facets(const core::LoadCase &load_case);

/// Lets go of held facets: those nearest to the area centroid of all of them stay, as many as it takes for the share.
/// @param share  in (0, 1] of their area
core::LoadCase with_held_share(core::LoadCase load_case, const core::TetraMesh &mesh, double share);

/// Whether the load case has one round tool, which can be moved.
bool has_movable_tool(const core::LoadCase &load_case);

/// The same load case with its round tool elsewhere: at the point of the surface nearest to that which is off its
/// middle by offset.x() along the projection of x on the surface (of y where the surface looks along x) and by
/// offset.y() perpendicular to it [m].
/// @param load_case  with has_movable_tool(), loads multiplied by its load_scale
/// @throws support::InputError where there is no room for it
core::LoadCase with_tool_moved(const core::LoadCase &load_case, const core::Body &body, const Eigen::Vector2d &offset);

/// The problem of a patient.
/// @param nominal  body and load case as their files have them, with loads scaled
/// @throws support::InputError where a tool has no room
core::Problem problem_of(const Patient &patient, const core::Problem &nominal);

} // namespace livermark::studies
