#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/load_case.hpp"
#include "core/problem.hpp"
#include "core/support/toml_input.hpp"
#include "load_cases/places/selector.hpp"

namespace livermark::load_cases {

/// A load case that is being read.
struct Reading {
    const toml::table &table; ///< the whole file, lengths in metres
    const std::filesystem::path &file;
    const core::TetraMesh &mesh;
    core::LoadCase &load_case;
};

/// Keys of a table that are more than numbers in SI units along the axes of the mesh.
struct Quantities {
    std::vector<std::string_view> lengths{};    ///< in the 'unit' of the file
    std::vector<std::string_view> directions{}; ///< vectors that turn with the patient
    bool has_place = false;                     ///< whether a selector stands in it
};

/// All that is said of an event in the file of a load case. One file each in events/, named as the key of its table,
/// [key] or [[key]].
struct EventReader {
    std::string name;            ///< the key, which is the file stem; set by the table
    const char *what;            ///< in messages on load cases that have it: "has a needle"
    const char *command = "run"; ///< of the program, that solves these load cases
    const char *folder;          ///< in which load cases with it ship, below the root
    bool in_time = false;        ///< whether time passes, and `run --static` leaves it out
    Quantities quantities{};
    std::vector<std::string_view> beside{};   ///< keys of the file that belong to it
    std::vector<std::string_view> required{}; ///< keys whose lack is said together with all else that is missing
    /// Adds what else is missing. Empty if nothing is.
    void (*look_for_missing)(const toml::table &load_case, std::vector<std::string> &missing) = nullptr;
    /// Reads what needs no body, before conditions are. Empty if all of it needs one.
    void (*begin)(const Reading &) = nullptr;
    /// Refuses what it does not go together with, once conditions are read. Empty if it goes with all.
    void (*refuse_company)(const Reading &) = nullptr;
    /// Reads it. Empty if it is read, or if the command of these load cases does so.
    void (*read)(const Reading &) = nullptr;
    /// Refuses what makes no sense once all is read. Empty if nothing is left to refuse.
    void (*check)(const Reading &) = nullptr;

    bool is_in(const toml::table &load_case) const { return load_case.contains(name); }
};

/// Every event of events/, in alphabetical order.
std::span<const EventReader> all_events();

/// The shape of a tool that touches: a ball of a 'radius', or a plate = "round" or "square" of a 'size' whose edges
/// have an 'edge_radius', a tenth of the size where it is left out.
/// @param press  along the axis of a plate
/// @throws support::InputError if a length is not positive, or a key does not belong to the shape
core::ToolShape tool_shape(const toml::table &tool, const core::Vector3 &press);

/// A tool that just touches a body, and the facet that it touches.
struct FirstTouch {
    core::Vector3 centre; ///< [m]
    int facet;
};

/// The place where a tool that comes from far away along a line first touches the body at rest. A ball always moves by
/// the gap that is left, which never leads into the body. A plate is looked at by the points of all facets: corners,
/// and those of core::facet_points() in parts of facets that are as small as its edges, or a sixteenth.
/// @param onto       a point of the line [m]
/// @param direction  along which it comes, of length 1; the axis of a plate
FirstTouch first_touch(const core::TetraMesh &mesh, const core::Vector3 &onto, const core::Vector3 &direction,
                       const core::ToolShape &shape);

/// Effect of a condition on facets.
struct Effect {
    core::ConditionKind kind;
    std::function<core::Vector3(int facet)> value;
    /// (N) what a prescribed displacement is multiplied by at each node. Empty where it is the same everywhere.
    std::vector<double> node_factor{};
    std::optional<core::RoundLoad> round{}; ///< how a traction is spread, unless it is even
    double press_depth = 0.0;               ///< of a place that presses, whose traction is one newton, see LoadCase
};

/// The keys that say what a condition puts on its place, see load_case_reader.hpp.
std::span<const std::string_view> effect_keys();

/// Keys among them whose values are lengths or vectors, and the place that stands beside them.
const Quantities &effect_quantities();

/// A place that stands apart from the places above it, with what is put on it.
struct PlacedCondition {
    Selection selection;
    Effect effect;
    double lost_area = 0.0; ///< part of the area of the selection that was given up, 0 to 1/4
};

/// Lets a new place yield to the conditions above it: it gives up the facets that have a condition already, and, where
/// it prescribes a displacement, those with a node to which a condition above prescribes another one. The effect is
/// that on what is left: a disc keeps its resultant.
/// @param table      the [[condition]]
/// @param selection  at least one facet
/// @param above      the load case with the conditions above this one
/// @throws NotOnBody if less than three quarters of the area are left; what read_effect() throws
PlacedCondition place_apart(const toml::table &table, Selection selection, const core::TetraMesh &mesh,
                            const core::LoadCase &above);

/// Brings the lengths of a load case to metres, by the 'unit' that it says, and takes the 'unit' out. Forces,
/// tractions, times and accelerations are in SI units whatever it says, and so are the lengths in these. The [[cut]]
/// stays as it is: meshes::cuts_of_file() reads it.
/// @param load_case  whose numbers, all of them, are ones that arithmetic can square
/// @throws support::InputError with file, line and remedy
void bring_to_metres(toml::table &load_case);

/// Turns the directions in a load case with a body, from LPS to the coordinates of its mesh: accelerations, all vectors
/// of conditions, the direction of a disc and the way that a tool or a ball slides. Points are places in the mesh and
/// stay. Nothing happens on a body in LPS, nor where the load case names none of the patches of BodyAxes.
/// @param load_case  the whole file; keeps the places of its lines
/// @throws NotOnBody where something has a direction and the axes of the body are in doubt, and where a disc is found
///         by a point of the mesh and a direction of the patient; support::InputError where a displacement is free
///         along an axis that is none of the mesh
void turn_directions(toml::table &load_case, const core::BodyAxes &axes);

/// Says at once what a load case lacks, where that is more than one thing: the conditions, a place or what happens
/// there in each of them, a condition that constrains, keys of its events. One thing alone is refused by who reads it.
/// @throws support::InputError
void refuse_missing_parts(const toml::table &load_case);

/// A load case that is a part of another file; see read_load_case() for what a table may hold.
/// @param file  gives the name of the load case, and the place in messages
/// @param table  gets its lengths in metres, see bring_to_metres()
/// @return without its text
/// @throws support::InputError as read_load_case()
core::LoadCase load_case_of_table(toml::table &table, const std::filesystem::path &file, const core::TetraMesh &mesh);

} // namespace livermark::load_cases
