#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/problem.hpp"
#include "core/solution.hpp"
#include "studies/study.hpp"

/// Patients of whom not all is known, and the outputs of their solutions.
namespace livermark::studies {

/// Differences from a body and a load case as their files have them. Values that are not set stay as they are.
struct Patient {
    std::optional<double> young_modulus{};     ///< of the first region [Pa]; others but tumours keep their ratio to it
    std::optional<double> poisson_ratio{};     ///< of all regions
    std::optional<double> tumour_contrast{};   ///< Young's modulus of tumours over that of the first region
    std::optional<double> shear_left{};        ///< part of all shear moduli that is left once tissue relaxed, in (0, 1]
    std::optional<double> density{};           ///< of all regions [kg/m^3]
    std::optional<double> capsule_stiffness{}; ///< E t of a capsule, which a body without one gets [N/m]
    std::optional<double> map_contrast{};      ///< see with_map_changed()
    std::optional<double> map_slope{};         ///< see with_map_changed()
    std::optional<double> held_share{};        ///< part of the area of the held facets that stays held, in (0, 1]
    std::optional<double> support_stiffness{}; ///< see with_soft_support() [Pa/m]
    std::optional<Eigen::Vector2d> tool_offset{}; ///< see with_tool_moved() [m]
};

/// The patient of parameters by name, tool_offset_1 and tool_offset_2 for the offset of the tool.
/// @param values  (P) SI
Patient patient_of(const std::vector<std::string> &names, const std::vector<double> &values);

/// The regions whose Young's modulus is above that of the first one, as they are in the files, but for those with names
/// of vessels; ascending.
std::vector<int> tumour_regions(const core::Body &body);

/// Factors of a map of stiffness f that has blurred contrasts, or has lost signal in depth: f^contrast exp(slope (s -
/// 1/2)), s from 0 where the body is most anterior to 1 where it is most posterior, at the centroids of tetrahedra.
/// @param body  with a map
/// @return shape (M)
std::vector<double> with_map_changed(const core::Body &body, double contrast, double slope);

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

/// The ratio of the stiffness of a soft support along the surface to that across it: that of a thin layer with a
/// Poisson's ratio of 1/4, at which every model of the suite is at ease.
inline constexpr double support_shear_ratio = 1.0 / 3.0;

/// A Robin condition in place of held facets, t = -k ((u . n) n + (u - (u . n) n) / 3), as ligaments give way: a layer
/// of soft material is put on the held facets, and its outer side is held. The layer is as thin as a twentieth of the
/// mean edge of these facets, so its elements are such a spring up to that part squared, in finite elements as well as
/// in springs. Models that are not linear feel the layer stretch: they have this condition only as long as the held
/// surface moves by much less than the layer is thick.
///
/// Nodes of the body keep their numbers, those of the layer come behind. Facets keep their numbers too: the held ones
/// are now those of the outer side; the rim of the layer comes behind, free. The layer is the last region, "support".
/// No capsule is on it, nor below it: facets of the layer are in the patch core::wound_patch beside their own.
/// @param problem    with a held facet
/// @param stiffness  k [Pa/m], > 0
/// @throws support::InputError if the held surface folds back within the thickness
core::Problem with_soft_support(const core::Problem &problem, double stiffness);

/// Quantities of a solution: the stiffness at the first tool, and how far the node that moves most and the centroid of
/// the largest tumour move.
enum class Output { stiffness_at_tool, peak_displacement, tumour_displacement };

const char *name_of(Output output);

/// The outputs that a body under a load case has: the first needs a tool, the last a tumour.
std::vector<Output> outputs_of(const core::Problem &nominal);

/// The outputs of a solution.
struct OutputValues {
    std::vector<double> values{}; ///< (O) stiffness [N/m], displacements [m]; NaN of a solution that is not ok
    core::Vector3 tumour = core::Vector3::Zero(); ///< displacement of the tumour [m]
};

/// @param problem  that was solved; nodes and regions of the nominal one come first
OutputValues values_of(const std::vector<Output> &outputs, const core::Problem &nominal, const core::Problem &problem,
                       const core::Solution &solution);

/// Samples of patients, solved here. Points, statistics, indices, files and tables are those of
/// python/livermark/studies/sensitivity/, which is asked for them.

/// The options of `livermark sensitivity`.
struct SensitivityOptions {
    std::string body;
    std::vector<std::string> load_cases{"palpation", "retraction"};  ///< of the small regime
    std::string model = "fem_p2p1";                                  ///< that solves the samples
    std::vector<std::string> compared{"nodal_neo_hookean", "lloyd"}; ///< models in the budget, the first one judged
    int num_samples = 128;
    std::string ranges;             ///< file; the one that ships if empty
    bool reference_on_mesh = false; ///< compares with the reference on the mesh, whose own error stays unknown
    bool without_law = false;       ///< does not solve the large load case with two laws
    std::string output;             ///< folder for <body>/sensitivity.<load case>.h5
};

struct SensitivityResults {
    std::vector<std::string> files; ///< of each load case
    std::vector<std::string> notes; ///< what a user should know, a sentence each
    std::string folder;             ///< of the files
};

/// Solves a body under each load case for quasi-random patients, and for the one of the files with several models, and
/// estimates what the outputs depend on. A file of the same body, load case, model and ranges is gone on with.
/// @throws support::InputError for bad input, a load case of the large regime or one that moves, too few samples, and
///   where OpenTURNS is missing
SensitivityResults study_sensitivity(const SensitivityOptions &options, const std::string &command_line,
                                     const ProgressReport &report);

/// Tables and sentences of such files, or all of them as JSON in SI units.
/// @param format  "text", "markdown" or "json"
std::string shown_sensitivities(const std::vector<std::string> &files, const std::string &format);

} // namespace livermark::studies
