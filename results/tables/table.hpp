#pragma once

#include <span>
#include <string>
#include <vector>

#include "results/records/result.hpp"
#include "results/tables/table_layout.hpp"

namespace livermark::results {

/// The cells of text_table().
Layout error_table(std::span<const Result> results);

/// One row per body, load case and model, in the order of the results: peak displacement [mm]; relative L2 error [%],
/// greatest error [mm], reaction and (signed) energy error [%], all against the reference; the reference's own
/// uncertainty [%] and which models are within it; stiffness at the tool, with its sign [%]; how far the model is from
/// its own linearised solution [%]; set-up and solve time [s]; and status. The reference is marked. What has no value
/// is "-". The radii of tools, the factors of scaled loads, yielded_places() and the reason of every failure stand
/// below the table.
/// @return lines of equal width for a terminal
std::string text_table(std::span<const Result> results);

/// A line with the places that lost a part of their area, see core::LoadCase::yielded; empty where there are none.
std::string yielded_places(std::span<const Result> results);

/// A line for each time-dependent load case below an empty one: that the rows of a table are its static start, how
/// uncertain the motion is that others are compared with, where that is known, and how the motions compare; nothing if
/// nothing moves.
/// @param bullet  before each line
std::string motion_lines(std::span<const Result> results, const std::string &bullet);

/// The same table in GitHub's Markdown.
std::string markdown_table(std::span<const Result> results);

/// One row per body and model, in the order in which they appear: relative L2 error of the static solution in each load
/// case
/// [%] and their mean over those that count (see counts_in_means()), with their number where a model has not solved all
/// of them; the reference's own mean uncertainty [%]; the worst error of the reactions [%]; and the mean of
/// the seconds that a load case takes once everything is set up. A model that is the reference in a load case has
/// "reference" there, "not compared" if that has found no solution, and " !" behind its error where the load leaves its
/// regime; what did not come to an end has its status.
Layout summary(std::span<const Result> results);

/// Frequencies of each model in Hz, a row for each mode and the seconds last; beside them how far each frequency is
/// from that of the reference, and the modal assurance criterion of the shapes, which tells whether modes of one number
/// are the same.
/// @param result     every model with as many modes
/// @param reference  name of a model; without it frequencies stand alone
Layout modes_table(const Result &result, std::string_view reference);

/// One row per body, load case and model of the large regime: displacement, position of tumours, reactions, volume and
/// the shape of tetrahedra, see core::PathComparison and core::Deformation.
Layout large_table(std::span<const Result> results);

/// Meaning of its columns.
std::string large_legend();

/// Force against way of a place, at each point of the path that a model came to.
struct ForceCurve {
    std::string place; ///< name of the constraint that moves, or "load"
    std::string model;
    std::vector<double> way;   ///< of the place [m]
    std::vector<double> force; ///< along it [N]
};

/// Curves of each constraint that moves and each model: the prescribed way with the force of the model; constraints
/// that only hold have none. Of tractions that keep their direction, where they have a resultant, the given force with
/// the way of the model: the mean displacement of the places, weighted with the traction, along the resultant.
std::vector<ForceCurve> force_curves(const Result &result);

/// A row for each of these curves.
Layout force_table(std::span<const Result> results);

/// Load cases in which time passes in the material, others are left out: a row for each model and tool, with the
/// force at the whole load when it is first reached, at the last record of the whole load and what that is of the
/// first; how far the force over time is from that of the reference; and the heat of the last cycle. Of a given
/// traction the displacement takes the place of the force.
Layout slow_table(std::span<const Result> results);

/// Meaning of its columns.
std::string slow_legend();

} // namespace livermark::results
