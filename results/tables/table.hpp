#pragma once

#include <span>
#include <string>
#include <vector>

#include "results/records/result.hpp"
#include "results/tables/table_layout.hpp"

namespace livermark::results {

/// A row for each body, load case and model, in the order of the results; the reference is marked.
Layout error_table(std::span<const Result> results);

/// error_table() with what has to be said below it: marks, radii of tools, factors of scaled loads, yielded_places(),
/// motion_lines() and the reason of every failure. As lines of equal width for a terminal, and in GitHub's Markdown.
std::string text_table(std::span<const Result> results);
std::string markdown_table(std::span<const Result> results);

/// A line with the places that lost a part of their area, see core::LoadCase::yielded; empty where there are none.
std::string yielded_places(std::span<const Result> results);

/// An empty line, and one for each load case that moves: its rows are the static start, how uncertain the motion of the
/// reference is, and how the motions compare; nothing if nothing moves.
/// @param bullet  before each line
std::string motion_lines(std::span<const Result> results, const std::string &bullet);

/// A row for each body and model, in the order in which they appear, and a column for each load case. Means are over
/// those that count (counts_in_means()), with their number where a model has not solved all; a mark is behind errors
/// where the load leaves its regime.
Layout summary(std::span<const Result> results);

/// Frequencies, a row for each mode and the seconds last; the modal assurance criterion tells whether modes of one
/// number are the same.
/// @param result     every model with as many modes
/// @param reference  name of a model; without it frequencies stand alone
Layout modes_table(const Result &result, std::string_view reference);

/// The same of the large regime, see core::PathComparison and core::Deformation.
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

/// A row for each model and tool of load cases in which time passes in the material; of a given traction the
/// displacement takes the place of the force.
Layout slow_table(std::span<const Result> results);

/// Meaning of its columns.
std::string slow_legend();

} // namespace livermark::results
