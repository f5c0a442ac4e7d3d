#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/load_case.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "results/records/result.hpp"
#include "results/tables/table_layout.hpp"

namespace livermark::results {

/// The name of the body of a result, with Poisson's ratio of its first region where the results have it with several.
std::string body_label(const Result &result, std::span<const Result> all);

/// Whether a body is there to check models, as the beam is, whose solution is known. Tables have it behind those that
/// somebody has come for.
bool is_for_checks(const std::string &body);

/// The names of bodies and the names of their models, each pair once: bodies by their names, those that are for checks
/// behind, models in the order in which they appear.
/// @param takes_part  whether a result takes part; all do if there is none
std::vector<std::pair<std::string, std::string>> bodies_and_models(std::span<const Result> results,
                                                                   bool (*takes_part)(const Result &) = nullptr);

/// Whether a body is there with several Poisson's ratios.
bool has_several_poisson_ratios(std::span<const Result> results);

/// The error of the reactions; nothing where there is no resultant, and where one place holds the body against loads
/// that are given, so that every model has the same resultant.
std::optional<double> told_reaction_error(const core::Comparison &comparison, const Result &result);

/// A row for each body and model and columns for each Poisson's ratio, over the load cases that count
/// (counts_in_means()); stiffness_at_tool() in absolute value. The reference has its own uncertainty for an error. A
/// load case that did not come to an end makes the mean "-" and its status the worst.
Layout overview(std::span<const Result> results);

/// The two means of overview(), in columns for each body_label().
Layout mean_errors(std::span<const Result> results);

/// Cost and error; NaN where that is not known.
struct CostAndError {
    double cost;
    double error;
};

/// Membership of the Pareto front: no other is at least as good in both and better in one. What has a NaN is
/// not.
/// @return shape of points
std::vector<bool> pareto_front(std::span<const CostAndError> points);

/// The place of a model among those of one body, or of one body and load case.
struct Standing {
    std::string body;      ///< body_label()
    std::string load_case; ///< empty for the mean over all
    std::string model;
    std::string integrator; ///< of a history, else empty
    double time_step;       ///< [s]; NaN where that is not known
    CostAndError at;        ///< seconds of one core per simulated second, relative L2 error
    bool is_on_front;
    /// Error of the motion that it is compared with, relative L2; NaN where that is not known, and at rest.
    double uncertainty = std::numeric_limits<double>::quiet_NaN();
    /// Mean at rest over the same load cases of the absolute value of stiffness_at_tool(); NaN where it is not
    /// known.
    double stiffness = std::numeric_limits<double>::quiet_NaN();
    /// At rest, over how many load cases of how many of the body the mean is; equal in motion. Who has not solved all
    /// is not ranked, and does not push others from the front.
    std::size_t num_cases = 1, num_in_table = 1;
    std::string reference{}; ///< whose motion a motion is compared with; empty at rest

    bool is_ranked() const { return num_cases == num_in_table; }
};

/// The rows of static_accuracy() as numbers.
std::vector<Standing> standings_at_rest(std::span<const Result> results);

/// The rows of motion_accuracy() as numbers.
std::vector<Standing> standings_in_motion(std::span<const Result> results);

/// Error against cost at rest, a row for each body_label() and model that moves in time: means over the load cases that
/// count, with 0.8 of the shortest critical step over the load cases, or the step of its history. Of several runs of
/// one load case the last one's error counts.
Layout static_accuracy(std::span<const Result> results);

/// The same of motions, a row for each load case, integrator and step. Results of one problem may come from several
/// runs.
Layout motion_accuracy(std::span<const Result> results);

/// Whether a model is what another one is compared with.
bool is_reference(const ModelResult &model, const Result &result);

/// Stiffness at the tool of a model under a load case; along a path of loads the one of the largest absolute value. NaN
/// where there is none.
double stiffness_at_tool(const ModelResult &model);

/// Stiffness with its sign, and a mark where fingers feel it [%]; "-" for NaN.
std::string stiffness_cell(double stiffness);

/// The same of an absolute value.
std::string size_cell(double size);

/// Stiffness at the tool of one model over load cases.
struct StiffnessCases {
    std::vector<double> sizes{}; ///< absolute values
    bool has_positive = false, has_negative = false;
    double worst = std::numeric_limits<double>::quiet_NaN();
    std::string worst_load_case{};

    /// A NaN is left out.
    void enter(double stiffness, const std::string &load_case);
    /// Mean of absolute values; NaN where there are none.
    double mean() const;
    /// Mean, and median, of absolute values [%].
    std::string mean_cell() const;
    std::string median_cell() const;
    /// The median with a sign where all values have the same.
    std::string signed_median_cell() const;
    /// The one of the largest absolute value, with its sign and its load case.
    std::string worst_cell() const;
};

/// Meaning of the columns and the mark.
std::string tool_legend();

/// Meaning of means over load cases.
std::string mean_tool_legend();

/// A line with the radius of the smallest tool of each load case over the edge length under it, and one with that of
/// the contact of each ball along its path; empty without tools.
std::string tool_radii(std::span<const Result> results);

/// A sentence on the balls whose contact has a radius of less than core::smallest_contact edges; nothing where there is
/// none.
std::optional<std::string> note_on_small_contacts(std::span<const Result> results);

/// A sentence on the tools other than balls with a radius of less than two edges; nothing where there is none.
std::optional<std::string> note_on_small_tools(std::span<const Result> results);

/// Whether a pressure acts on the whole free surface: every boundary triangle either has a prescribed displacement or a
/// traction along its normal, and at least one has a traction. Such a load changes the volume, and its error shows
/// Poisson's ratio before all else.
/// @param load_case  of the mesh
bool is_pressure_on_whole_surface(const core::LoadCase &load_case, const core::TetraMesh &mesh);

/// A row for each body and model, and four columns for each Poisson's ratio, the largest first: medians over the load
/// cases that count (counts_in_means()), stiffness_at_tool() in absolute value. Load cases with pressure on the whole
/// free surface have a column of their own, and no part in the others.
///
/// The reference has "+-" and the median of its own uncertainty. A model whose median is below that has a star, unless
/// it has not solved all load cases, whose number is behind it then: "5.32 (3 of 11)". Of several results for one body,
/// Poisson's ratio and load case the last one counts.
Layout median_errors(std::span<const Result> results);

/// The two numbers that lead every table, of one model on one body.
struct TwoNumbers {
    /// Cells of median_errors(), the stiffness with a sign where that of all load cases is the same.
    std::string error, stiffness;
    /// For an order: the median of the relative L2 error and that of the absolute stiffness at the tool; NaN where
    /// there is none.
    double median_error, median_stiffness;
    bool is_spring_model;

    /// The larger of the two medians; NaN where one is. Models without any stiffness at the tool go by the other.
    double larger(bool has_tools) const;
};

/// Numbers of median_errors() for a model; of a body with nothing but pressure on its surface the error is that one.
TwoNumbers two_numbers(std::span<const Result> results, const std::string &body, double poisson_ratio,
                       const std::string &model);

/// Whether median_errors() has anything to take a median over: several load cases of one body at one Poisson's ratio.
bool has_several_load_cases(std::span<const Result> results);

/// Sentences on the columns and marks of median_errors(), with the names of the load cases.
std::string median_legend(std::span<const Result> results);

/// Both numbers of one model on one body.
struct BriefNumbers {
    std::string body; ///< with its Poisson's ratio where there are several
    std::string model;
    TwoNumbers numbers;
};

/// Numbers of each body and each model that any body has, in the order in which they appear.
std::vector<BriefNumbers> brief_numbers(std::span<const Result> results);

/// A row for each model and two columns for each body, at each Poisson's ratio if there are several: the median over
/// load cases of the relative L2 error [%] and that of the absolute stiffness at the tool [%], as in median_errors(),
/// with a sign where all load cases have the same.
Layout brief(std::span<const Result> results);

/// The best three spring models of a body: those whose larger number is smallest, so that both are good.
struct BestSprings {
    std::string body;
    std::vector<BriefNumbers> models;
    bool has_tools = false; ///< whether any of its springs has a stiffness at the tool
};

/// The best springs of each body that has springs.
std::vector<BestSprings> best_springs(std::span<const Result> results);

/// Lines on the best springs of each body, and on what the columns mean.
std::string brief_legend(std::span<const Result> results);

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
