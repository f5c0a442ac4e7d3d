#include "studies/advise/advise.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <utility>

#include "models/mass_spring_model.hpp"
#include "models/model_table.hpp"
#include "support/input_error.hpp"

namespace livermark::studies {

namespace {

/// Springs of the suite on a body, of those models that errors are known of.
struct KnownSprings {
    ExpectedError error;
    std::string summary;
    msm::ElasticBody springs;
    bool is_coupled; ///< no spring has a stiffness of its own
};

std::vector<KnownSprings> known_springs(const core::Body &body, const Evidence &evidence) {
    const auto shared = std::make_shared<const core::Body>(body);
    std::vector<KnownSprings> known;
    for (const auto &model : models::all_models())
        if (const auto *error = evidence.find(model.name))
            if (auto springs = models::springs_of(model, shared))
                known.push_back({*error, model.summary, std::move(springs->body), springs->springs.stiffness.empty()});
    return known;
}

/// @param in_both  the error of both regimes, NaN where one is not known
/// @param small    that of small loads
template <class InBoth>
std::vector<std::size_t> ranked_by(const std::vector<KnownSprings> &known, InBoth in_both,
                                   double ExpectedError::*small) {
    std::vector<std::size_t> order;
    for (std::size_t k = 0; k < known.size(); ++k)
        if (!std::isnan(known[k].error.*small))
            order.push_back(k);
    std::ranges::stable_sort(order, {}, [&](std::size_t k) {
        const double both = std::invoke(in_both, known[k].error);
        return std::pair(std::isnan(both), std::isnan(both) ? known[k].error.*small : both);
    });
    return order;
}

/// Costs that were found, by number of the springs.
class Costs {
  public:
    Costs(const core::Body &body, const std::vector<KnownSprings> &known, const FindStepCost &find, Steps &steps)
        : body_(body), known_(known), find_(find), steps_(steps) {}

    const StepCost &of(std::size_t k) {
        const auto found = costs_.find(k);
        if (found != costs_.end())
            return found->second;
        steps_.next(fmt::format("{}: critical step, and time of a step", known_[k].error.model));
        return costs_.emplace(k, find_(body_, known_[k].springs)).first->second;
    }

  private:
    const core::Body &body_;
    const std::vector<KnownSprings> &known_;
    const FindStepCost &find_;
    Steps &steps_;
    std::map<std::size_t, StepCost> costs_;
};

std::vector<ModelAdvice> best_of(const std::vector<std::size_t> &order, const std::vector<KnownSprings> &known,
                                 Costs &costs, Advice &advice) {
    std::vector<ModelAdvice> best;
    for (const auto k : order) {
        if (best.size() == num_ranked)
            break;
        const auto &cost = costs.of(k);
        const auto &name = known[k].error.model;
        if (!advice.budget || cost.seconds_per_frame() <= *advice.budget)
            best.push_back({known[k].error, known[k].summary, cost});
        else if (std::ranges::find(advice.over_budget, name) == advice.over_budget.end())
            advice.over_budget.push_back(name);
    }
    return best;
}

void refuse_budget(const std::vector<KnownSprings> &known, Costs &costs, double budget) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < known.size(); ++k)
        least = std::min(least, costs.of(k).seconds_per_frame());
    throw support::InputError(
        fmt::format("--budget {:.3g} ms: every model takes longer for a frame of 1/60 s on this mesh, the cheapest one "
                    "{:.3g} ms; give more time, or mesh the body with fewer or larger tetrahedra",
                    1e3 * budget, 1e3 * least));
}

} // namespace

Advice advise(const core::Body &body, const AdviceOptions &options, const ProgressReport &report) {
    Advice advice;
    advice.body = body_figures(body, options.tool_radius);
    advice.budget = options.budget;
    advice.evidence = shipped_evidence({.poisson_ratio = advice.body.material().poisson_ratio,
                                        .tool_radius_in_edges = advice.body.tool_radius_in_edges(),
                                        .tetrahedra = advice.body.mesh.num_tetrahedra});
    if (const auto *linear = advice.evidence.find(models::baseline_name()))
        advice.linear_tetrahedra = *linear;
    const auto known = known_springs(body, advice.evidence);
    if (known.empty())
        throw support::InputError("results/cohorts has errors of no model of springs; restore it from git");
    Steps steps(static_cast<int>(known.size()), report);
    Costs costs(body, known, options.find_cost, steps);
    advice.touch =
        best_of(ranked_by(known, &ExpectedError::in_both_at_tool, &ExpectedError::at_tool), known, costs, advice);
    auto uncoupled = ranked_by(known, &ExpectedError::in_both_at_tool, &ExpectedError::at_tool);
    std::erase_if(uncoupled, [&](std::size_t k) { return known[k].is_coupled; });
    advice.uncoupled = best_of(uncoupled, known, costs, advice);
    advice.position = best_of(ranked_by(known, &ExpectedError::in_both_relative_l2, &ExpectedError::relative_l2), known,
                              costs, advice);
    if (advice.position.empty())
        refuse_budget(known, costs, *options.budget);
    const auto &first = advice.touch.empty() ? advice.position.front() : advice.touch.front();
    const auto springs = std::ranges::find(known, first.error.model, [](const auto &k) { return k.error.model; });
    advice.caveats = find_caveats(body, options, advice, scaled_critical_time_step(body, springs->springs));
    if (advice.caveats.size() > num_ranked)
        advice.caveats.resize(num_ranked);
    return advice;
}

} // namespace livermark::studies
