#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/problem.hpp"
#include "studies/advise/body_figures.hpp"
#include "studies/advise/evidence.hpp"
#include "studies/advise/step_cost.hpp"
#include "studies/progress.hpp"

/// Which springs to take for a body: what models were off by on other bodies like it, and what they cost on it.
namespace livermark::studies {

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

} // namespace livermark::studies
