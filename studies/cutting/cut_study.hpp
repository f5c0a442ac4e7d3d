#pragma once

#include <optional>
#include <string>
#include <vector>

#include "meshes/io/body_reader.hpp"
#include "results/records/cut.hpp"
#include "studies/cutting/moving_cut.hpp"
#include "studies/progress.hpp"

namespace livermark::studies {

/// What `livermark cut` was asked for.
struct CutStudyOptions {
    std::string body = "liver_healthy"; ///< name or path
    std::string load_case = "traction"; ///< name or path
    std::vector<std::string> models;    ///< beside the reference on the mesh; all that run by default if there are none
    std::vector<double> blade;          ///< four corners in turn, twelve numbers; its edge goes from 0-1 to 3-2 [m]
    int num_steps = 20;
    double toughness = 164.0; ///< [J/m^2]
    /// That models are compared in: of a load case of the small regime the large one may be asked for. That of the load
    /// case if not set.
    std::optional<core::Regime> regime;
    int num_refined = 2; ///< how often the reference is refined at the rim of the wound in the end: 0, or 2 and more
    CutMotionOptions motion; ///< of methods that move meanwhile
    meshes::MaterialOverride material;
    std::string output; ///< folder for <body>/cut.<load case>.h5, or cut.<load case>.large.h5 for another regime
};

struct CutResults {
    results::CutFile file;
    std::vector<std::string> notes; ///< what a user should know of input and result, a sentence each
};

/// Lets a blade go into a body under the loads of a load case, in steps: divide, find the equilibrium of what is left
/// under the same loads, and divide further. All models solve the same bodies, so the reference on the mesh tells their
/// errors. Under a load case of the small regime the blade meets the body as it is at rest, also where models of the
/// large one are compared; under one of the large regime where the reference has moved it to. Cuts go along facets. In
/// the end the reference is solved on finer meshes of the cut body too, and where the blade meets the body at rest on
/// those of the exact cut.
///
/// Loads keep their size and direction while the blade goes on, so what a step sets free is the work of the loads in
/// it less what more is stored. Where a model other than the reference finds no equilibrium its records are NaN.
/// Methods that move go on from one cut body to the next, which are those of the reference; only under a load case of
/// the small regime, where the blade meets the body as it is at rest.
/// @throws support::InputError for bad input: a load case that is none of constant loads, a blade that misses, a body
///         that falls apart, a model that takes no part, no equilibrium of the reference
CutResults let_blade_in(const CutStudyOptions &options, const std::string &command_line, const ProgressReport &report);

} // namespace livermark::studies
