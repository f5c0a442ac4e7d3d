#pragma once

#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/load_case.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "core/support/input_error.hpp"
#include "core/support/toml_input.hpp"

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

/// Keys of a table that has a place: its own, and those of all selectors.
std::vector<std::string_view> keys_with_place(std::initializer_list<std::string_view> own = {});

/// Finds the place that a [[condition]] names, by the one selector whose key it has.
/// @throws support::InputError if it names none or several, NotOnBody if no facet is there
Selection select_facets(const toml::table &condition, const core::TetraMesh &mesh, const core::LoadCase &above);

/// Finds the node in the middle of the patch that a [[probe]] names: of the patch's nodes the one nearest to its area
/// centroid.
/// @throws support::InputError if there is no such patch, or if it has no facet
int select_node(const toml::table &probe, const core::TetraMesh &mesh);

/// The little geometry that selectors and needles share. Facets are indices into mesh.boundary_triangles.

std::vector<int> all_facets(const core::TetraMesh &mesh);

/// Nodes of some facets, each once, in ascending order.
std::vector<int> nodes_of(const std::vector<int> &facets, const core::TetraMesh &mesh);

/// The facets of a patch, in ascending order; none if it is empty.
/// @param place  where its name stands, for the message
/// @throws NotOnBody if the body has no such patch
std::vector<int> facets_of_patch(const std::string &name, const toml::node &place, const core::TetraMesh &mesh);

/// [m]
core::Vector3 facet_centroid(const core::TetraMesh &mesh, int facet);

/// Sum of their areas [m^2].
double area_of(const std::vector<int> &facets, const core::TetraMesh &mesh);

/// Their area centroid [m].
/// @param facets  at least one
core::Vector3 middle_of(const std::vector<int> &facets, const core::TetraMesh &mesh);

struct SurfacePoint {
    int facet = 0;
    core::Vector3 point; ///< [m], on it
};

/// The point of the facets that is nearest to a point [m].
/// @param facets  at least one
SurfacePoint nearest_point(const std::vector<int> &facets, const core::TetraMesh &mesh, const core::Vector3 &point);

/// Largest distance from the surface of a point that is meant as one of it, over the size of the body.
inline constexpr double farthest_from_surface = 0.1;

/// The same of a point that somebody gives, over the whole surface.
/// @param table     has the point as this key, for the message
/// @param farthest  that it may be from the surface [m]
/// @throws NotOnBody for one that is farther, most often one in another unit, with the nearest point of the surface in
///   metres and in millimetres
SurfacePoint nearest_to_given(const toml::table &table, std::string_view key, const core::TetraMesh &mesh,
                              const core::Vector3 &point, double farthest);

/// Refuses the size of a place that is larger than the body, most often one in another unit.
/// @param table  has the length as this key, for the message
/// @throws NotOnBody
void refuse_beyond_body(const toml::table &table, std::string_view key, double length, const core::TetraMesh &mesh);

/// Centroid of the volume of a region [m].
/// @param place  where its name stands, for the message
/// @throws NotOnBody if the body has no such region
core::Vector3 region_centroid(const std::string &name, const toml::node &place, const core::TetraMesh &mesh);

enum class Exit { first, last };

/// Point where a ray leaves the body for the first or the last time.
/// @param direction  not zero
/// @return nothing if it never does
std::optional<SurfacePoint> exit_point(const core::TetraMesh &mesh, const core::Vector3 &origin,
                                       const core::Vector3 &direction, Exit which);

/// Refuses a body that can move as a whole without any prescribed displacement being in the way: it has no static
/// solution. A rigid motion u(x) = t + w x (x - c) leaves all constrained components alone if it is in the null space
/// of
///   sum over the constrained components i of the nodes x of  a a^T,   a = (e_i, (x - c) x e_i / r)
/// with c the centroid of the constrained nodes and r their root mean square distance from it.
/// @param mesh       num_boundary_triangles facets
/// @param load_case  at least one facet with a prescribed displacement
/// @param file       for the message
/// @throws NotOnBody that says along or about which axis the body can move
void refuse_free_body(const core::TetraMesh &mesh, const core::LoadCase &load_case, const std::string &file);

} // namespace livermark::load_cases
