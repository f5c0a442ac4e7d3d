#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/load_case.hpp"
#include "core/support/toml_input.hpp"

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

} // namespace livermark::load_cases
