#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/load_case.hpp"
#include "core/support/input_error.hpp"
#include "core/support/toml_input.hpp"
#include "core/tool/round_load.hpp"

namespace livermark::load_cases {

/// A load case that does not fit this body: it names a patch, region or place which the body does not have, or there is
/// no room for its places beside each other. It may fit another body.
class NotOnBody : public support::InputError {
  public:
    /// @param where   file and line, for the message
    /// @param reason  what does not fit, a clause
    NotOnBody(const std::string &where, std::string reason, const std::string &remedy);

    const std::string &reason() const { return reason_; }

  private:
    std::string reason_;
};

/// Boundary triangles that a condition applies to.
struct Selection {
    std::string name;                      ///< of the place, for reactions
    std::vector<int> facets;               ///< indices into mesh.boundary_triangles, ascending
    std::optional<double> area{};          ///< of the place that was meant [m^2], where facets only come near it
    std::optional<core::RoundLoad> tool{}; ///< what presses there, unless it is flat
};

/// (T) what a pressure or traction is multiplied by on each facet, 0 outside the place: a round tool presses most in
/// the middle, and a mesh has no facets that make a circle, so that the area of the place that was meant over that of
/// the facets is a factor in it. The resultant is the same on every mesh.
std::vector<double> load_shares(const Selection &selection, const core::TetraMesh &mesh);

/// Mean outward unit normal of the facets, by what the tool presses on them; NaN where their area vectors cancel, as on
/// a closed surface.
core::Vector3 pressed_normal(const Selection &selection, const core::TetraMesh &mesh);

/// Whether the table of a place says profile = "round", not "flat", which it is if nothing is said.
/// @throws support::InputError for another profile
bool is_round(const toml::table &place);

/// Whether a [[condition]] prescribes a displacement, so that its place has the facets whose centroids are inside; a
/// load has all that reach into it.
bool prescribes_displacement(const toml::table &condition);

/// A way to say in a [[condition]] where it applies. One file each in selectors/, named as the key.
struct Selector {
    std::string name; ///< the key, which is the file stem; set by the table
    /// @param condition  has the key
    /// @param above      with the conditions above this one
    /// @return without facets where nothing is in the place
    /// @throws support::InputError for what is written wrongly, NotOnBody for what this body does not have
    Selection (*select)(const toml::table &condition, const core::TetraMesh &mesh, const core::LoadCase &above);
};

/// Every selector of selectors/, in alphabetical order.
std::span<const Selector> all_selectors();

/// Finds the place that a [[condition]] names, by the one selector whose key it has.
/// @throws support::InputError if it names none or several, NotOnBody if no facet is there
Selection select_facets(const toml::table &condition, const core::TetraMesh &mesh, const core::LoadCase &above);

/// Finds the node in the middle of the patch that a [[probe]] names: of the patch's nodes the one nearest to its area
/// centroid.
/// @throws support::InputError if there is no such patch, or if it has no facet
int select_node(const toml::table &probe, const core::TetraMesh &mesh);

} // namespace livermark::load_cases
