#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/problem.hpp"
#include "meshes/io/mesh_checks.hpp"
#include "msm/elastic_body.hpp"
#include "results/records/cohort.hpp"
#include "studies/study.hpp"

namespace livermark::studies {

/// A frame of a display [s].
inline constexpr double frame = 1.0 / 60.0;

struct StepCost {
    /// 2 over the highest frequency of the body when nothing is constrained, which bounds it with any constraint from
    /// below: symplectic Euler without damping [s].
    double critical_time_step = 0.0;
    double seconds_per_step = 0.0; ///< processor time of one core [s]
    bool is_on_vector_units =
        true; ///< false where the fast kernels do not know the springs, and plain loops were timed

    /// With the usual margin [s].
    double safe_time_step() const;
    /// Whole steps of a frame, each no longer than that.
    int steps_per_frame() const;
    /// Processor time of these [s].
    double seconds_per_frame() const { return steps_per_frame() * seconds_per_step; }
};

/// Critical step of springs with nothing constrained, as StepCost has it [s].
double critical_time_step(const core::Body &body, const msm::ElasticBody &springs);

/// Finds the step and times real steps of symplectic Euler: the shortest of some, because other programs take turns.
/// @param springs  of the body
StepCost step_cost(const core::Body &body, const msm::ElasticBody &springs);

/// The critical step with selective mass scaling of stiff parts (msm::scale_masses()); the plain one where none is
/// stiff [s].
double scaled_critical_time_step(const core::Body &body, const msm::ElasticBody &springs);

/// Springs for a body: errors of models on other bodies like it, on which nothing of theirs was chosen, and their cost
/// on it.

/// Folder of the cohort files that ship, below the root.
inline constexpr const char *cohorts_folder = "results/cohorts";

/// The body in question, as far as errors depend on it.
struct BodyInQuestion {
    double poisson_ratio = 0.0;        ///< of the region of the largest volume
    double tool_radius_in_edges = 0.0; ///< radius of the tool over the mean length of edges of the surface, > 0
    int tetrahedra = 0;
};

/// Errors of one model, as far as they are known: relative, and NaN where nothing is known. Where a model has not come
/// to an end it counts in medians as infinitely wrong.
struct ExpectedError {
    std::string model;
    double at_tool = nan;          ///< median of the absolute value of stiffness at the tool under small loads
    double worst_at_tool = nan;    ///< the one of the largest absolute value, with its sign
    std::string worst_load_case{}; ///< of that one
    double relative_l2 = nan;      ///< median under small loads
    double worst_relative_l2 = nan;
    double large_at_tool = nan, large_relative_l2 = nan; ///< medians under large loads, along their paths at the tool
    std::size_t num_at_tool = 0, num_l2 = 0, num_large = 0; ///< of how many load cases on bodies these are
    std::size_t num_failed = 0, num_large_failed = 0;       ///< and on how many of these it has not come to an end

    static constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    /// The larger one of both regimes; NaN unless both are known.
    double in_both_at_tool() const { return std::isnan(at_tool) ? nan : std::max(large_at_tool, at_tool); }
    double in_both_relative_l2() const {
        return std::isnan(relative_l2) ? nan : std::max(large_relative_l2, relative_l2);
    }
};

/// Errors of all models, and what they are of.
struct Evidence {
    double poisson_ratio = 0.0;                                    ///< the nearest one at which errors are known
    double least_poisson_ratio = 0.0, largest_poisson_ratio = 0.0; ///< of all that are known
    double least_radius = 0.0, largest_radius = 0.0;               ///< of the tools of ExpectedError::at_tool, in edges
    int tetrahedra = 0;                ///< of the bodies of ExpectedError::relative_l2, as results::Cohort has it
    std::size_t num_bodies = 0;        ///< of the same
    std::string reference;             ///< that errors under small loads are against
    std::string large_reference{};     ///< the same of large ones; empty where none are known
    double large_poisson_ratio = 0.0;  ///< of these
    std::vector<ExpectedError> models; ///< in alphabetical order
    std::vector<std::string> sources;  ///< a sentence for each file

    /// @return nullptr for a model of which nothing is known
    const ExpectedError *find(const std::string &model) const;
};

/// A cohort file that was read.
struct KnownCohort {
    std::string file; ///< for people
    results::Cohort cohort;
};

/// Cohorts that ship.
/// @throws support::InputError if there is none, or one cannot be read
std::vector<KnownCohort> shipped_cohorts();

/// "livers of about 5000 tetrahedra".
/// @param tetrahedra  of results::Cohort: 0 where nobody asked for another number than the livers that ship have
std::string size_in_words(const char *bodies, int tetrahedra);

/// Errors of the unseen halves at the nearest Poisson's ratio. Under small loads those at the tool are of all cohorts
/// and of load cases whose tools have nearly as many edges in their radius; those of the displacement are of the cohort
/// of nearest number of tetrahedra and of all load cases. Under large loads both are of all that is known.
/// @throws support::InputError if the cohorts have no errors under small loads
Evidence find_evidence(std::span<const KnownCohort> cohorts, const BodyInQuestion &question);

/// The same of what ships.
Evidence shipped_evidence(const BodyInQuestion &question);

struct RegionFigures {
    std::string name;
    core::Material material;
    double volume = 0.0; ///< [m^3]
    int num_tetrahedra = 0;
    int num_parts = 0; ///< that are joined by faces
    /// Tetrahedra of the smallest part, and the diameter of the ball of its volume over the mean length of its edges.
    int smallest_part_tetrahedra = 0;
    double smallest_part_in_edges = 0.0;
};

struct BodyFigures {
    std::string name;
    meshes::MeshFigures mesh;
    std::vector<RegionFigures> regions; ///< (R) as in the mesh
    std::size_t main_region = 0;        ///< that of the largest volume
    double surface_edge = 0.0;          ///< mean length of the edges of the surface [m]
    double tool_radius = 0.0;           ///< [m]
    double thin_part = 0.0; ///< of the volume, in tetrahedra that have all corners on the surface: there is one layer

    double tool_radius_in_edges() const { return tool_radius / surface_edge; }
    const core::Material &material() const { return regions[main_region].material; }
};

/// @param tool_radius  [m], > 0
BodyFigures body_figures(const core::Body &body, double tool_radius);

/// Half of a fingertip 24 mm across, as in load_cases/palpation.toml [m].
inline constexpr double fingertip_radius = 0.012;
inline constexpr std::size_t num_ranked = 3;

/// Finds what a step of springs takes on a body.
using FindStepCost = std::function<StepCost(const core::Body &, const msm::ElasticBody &)>;

struct AdviceOptions {
    double tool_radius = fingertip_radius; ///< [m], > 0
    std::optional<double> budget{};        ///< of processor time for a frame [s]: models that take longer are no choice
    bool is_material_assumed = false;      ///< whether the body said nothing of its material
    FindStepCost find_cost = step_cost;    ///< measures
};

/// One model for the body.
struct ModelAdvice {
    ExpectedError error;
    std::string summary;
    StepCost cost;
};

/// One thing to know of this body before the numbers are believed.
struct Caveat {
    std::string about;   ///< a word for programs: "tool", "poisson_ratio", "lesions", ...
    double weight = 0.0; ///< the larger the more it matters
    std::string text;    ///< a sentence or two
};

/// One part of a liver that a body does not have, and what the reference is wrong by without it on a body that was
/// tried: absolute, as parts of one, medians and the worst of load cases.
struct LeftOutPart {
    std::string part; ///< a word for programs: "capsule", "vessels", "stiffness_map", "gravity", "ligaments"
    std::string words, remedy;
    std::string body, load_cases; ///< that were tried
    double at_tool = 0.0, worst_at_tool = 0.0;
    double relative_l2 = 0.0, worst_relative_l2 = 0.0;
};

/// The parts that a body does not have, the dearest first, by results/cohorts/left_out.toml; none of a body that is no
/// liver. What a load case says counts as left out of every body.
/// @throws support::InputError if the file is not there, or cannot be read
std::vector<LeftOutPart> parts_left_out(const core::Body &body);

struct Advice {
    BodyFigures body;
    Evidence evidence;
    std::vector<ModelAdvice> touch;    ///< the best first, num_ranked at most: by ExpectedError::in_both_at_tool()
    std::vector<ModelAdvice> position; ///< the same by in_both_relative_l2()
    /// As `touch`, of models whose springs have one stiffness on each edge, as engines know them: those that are
    /// coupled have none. Some have a volume term beside it.
    std::vector<ModelAdvice> uncoupled;
    std::optional<ExpectedError> linear_tetrahedra; ///< what most programs move, to compare with
    std::optional<double> budget;                   ///< as in the options [s]
    std::vector<std::string> over_budget;           ///< models that take longer, which are not ranked
    std::vector<Caveat> caveats;                    ///< the three that matter most, the most important first
    std::vector<LeftOutPart> left_out;              ///< parts of a liver that the body does not have
};

/// Looks at a body, finds critical steps and times steps of springs on it. Seconds on 20,000 tetrahedra.
/// A model is ranked by the larger of its errors under small and large loads. One of which nothing is known under large
/// loads comes behind all others.
/// @throws support::InputError where what ships has no errors, or every model takes longer than the budget
Advice advise(const core::Body &body, const AdviceOptions &options, const ProgressReport &report);

/// The caveats of a body, all of them, the most important first.
/// @param options            of the advice
/// @param advice             whose caveats are not found yet
/// @param scaled_time_step   critical step of the first model with selective mass scaling [s]
std::vector<Caveat> find_caveats(const core::Body &body, const AdviceOptions &options, const Advice &advice,
                                 double scaled_time_step);

/// An advice for programs: an object with body, evidence, touch, position, linear_tetrahedra, over_budget, caveats and
/// left_out. SI units, errors as parts of one. What is not known is left out. Names are those of the structs, and
/// docs/reference/advice.md has the list.
std::string to_json(const Advice &advice);

} // namespace livermark::studies
