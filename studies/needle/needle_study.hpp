#pragma once

#include <Eigen/Core>

#include <optional>
#include <string>
#include <vector>

#include "core/load_case.hpp"
#include "core/model.hpp"
#include "core/problem.hpp"
#include "core/tool/needle/needle.hpp"
#include "load_cases/experiments/needle_curves.hpp"
#include "meshes/io/body_reader.hpp"
#include "results/records/needle.hpp"
#include "studies/study.hpp"

namespace livermark::studies {

/// Drives a needle into a body, and draws it out again.
///
/// What is to be found at each depth of the hand is forces on the places: those of the shaft along the axis, within
/// friction times the length that each stands for; that of the tip, between nothing and what tears the tissue; and
/// those across, which hold the tissue at the shaft where it was when the tip passed. Where a force is within its
/// limits the tissue sticks to the needle, and at a limit it slides the way of the force (Coulomb's condition with a
/// given limit). Where the places move by u = b + C f these are the conditions of the least 1/2 f . C f - f . b within
/// limits, which has one solution. The tip advances where the tissue tears, until what it exerts is what tearing takes;
/// after the surface has given way it jumps.
///
/// A linear body moves by u = C f, so that this is all. Of another one, u = b + C f is what is known of it (see
/// Tissue): the body is pushed with the forces, corrects that, and so on until no place is elsewhere by more than a
/// thousandth of the spacing. Axis, friction over length at rest and what tearing takes are the same for all bodies.
/// Places are of the tissue at rest: in a body that moves far the needle stays on its line in space, and holds tissue
/// that was on that line at rest where it was when the tip passed, as core::MovingNeedle does.
/// @param body  at rest, or near it
/// @return where the body comes to no rest, with the depth in stopped_at: records on the way in are not numbers from
///   there on, those on the way out end
core::Insertion insert(core::PushedBody &body, const core::NeedleLine &line, const core::Needle &needle);

/// The same in a linear body.
/// @param compliance  C, shape (3 K, 3 K) of the places of the line [m/N], see core::Compliance
core::Insertion insert(const Eigen::MatrixXd &compliance, const core::NeedleLine &line, const core::Needle &needle);

/// Options of `livermark needle`.
struct NeedleOptions {
    std::vector<std::string> bodies;  ///< names or paths
    std::string load_case = "biopsy"; ///< of load_cases/needles/, or a path
    std::vector<std::string> models;  ///< all that run by default and can tell if there are none
    core::Regime regime = core::Regime::small;
    std::optional<double> step{};   ///< from record to record, at most [m], > 0; that of the load case, see below
    bool reference_on_mesh = false; ///< judged by the mixed elements on the mesh itself
    meshes::MaterialOverride material;
    std::string output; ///< folder for <body>/needle.<load case>.h5, or .large.h5
};

/// Step of the large regime where none is asked for [m]: each record takes several equilibria of the body.
inline constexpr double large_needle_step = 0.002;

/// Drives the needles of a load case into bodies, by each model, and writes a file for each body. All that is the
/// needle's is the same for all models and both regimes, see insert().
///
/// In the small regime what a model says is linear in the forces, and how it gives way along the needle is found once,
/// see core::Compliance. In the large one springs and hyperelastic elements come to rest under the forces themselves
/// (core::PushedBody), and the reference is hyperelastic; linear elements take part as they are, which shows what
/// linearity costs.
/// @throws support::InputError for bad input, for a model that cannot tell, and where a file cannot be written
Found<results::NeedleFile> drive_needles(const NeedleOptions &options, const std::string &command_line,
                                         const ProgressReport &report);

/// A body, and the needles that are driven into it.
struct NeedleProblem {
    core::Problem problem;
    std::vector<core::Needle> needles;
};

/// The reference of a regime, on meshes of its own or on the mesh itself.
core::Model needle_reference_model(bool on_mesh, core::Regime regime = core::Regime::small);

/// The load case on the bodies, one or more, in the regime and with the step that was asked for.
/// @param notes  what a user should know of the input, a sentence each
/// @throws support::InputError for bad input
std::vector<NeedleProblem> read_with_needles(const NeedleOptions &options, std::vector<std::string> &notes);

/// Puts models beside a measured needle.
///
/// The needle is the first of the load case, on its way as deep as the measurement goes, with the measured diameter.
/// The surface gives way at the measured force. Two numbers are fitted for each model: one factor of all of Young's
/// moduli, so that this happens at the measured depth; and the friction, by least squares over the stretches behind.
/// Toughness and the radius of the places are those of the load case, but for what a record does not allow: the tip may
/// not take more than the surface bore, and places are no wider than half of the way.
/// @param options  of one body; `output` is not written to
/// @param curve    see experiments::read_needle_curve()
/// @throws support::InputError as drive_needles(), for a curve without a puncture, for a way deeper than the needle of
///   the load case, and for one that is too short for the tetrahedra
results::MeasuredNeedle compare_with_measured(const NeedleOptions &options, const experiments::NeedleCurve &curve,
                                              const ProgressReport &report);

} // namespace livermark::studies
