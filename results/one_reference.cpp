#include "results/one_reference.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "core/mesh/tetra_mesh.hpp"
#include "core/units.hpp"

namespace livermark::results {

namespace {

double largest_length(const std::vector<core::Vector3> &displacement) {
    double largest = 0.0;
    for (const auto &u : displacement)
        largest = std::max(largest, u.norm());
    return largest;
}

bool has_known_uncertainty(const Result &result) {
    return result.reference_uncertainty && result.reference_uncertainty->reference == reference_of(result);
}

/// Whether a result has a reference with a solution, and nothing to compare with it: others are compared with every
/// reference that has one.
bool is_reference_alone(const Result &result) {
    return result.models.size() == 1 && !result.models.front().comparison &&
           result.models.front().solution.status == core::SolutionStatus::ok;
}

/// "fem_p2p1, fem_p2p1_refined: why they have no solution", of models that give the same reason; empty if none does.
std::string reasons(const Result &result) {
    std::vector<std::pair<std::string, std::string>> models_of_reason;
    for (const auto &model : result.models) {
        const auto &[status, message] = std::tie(model.solution.status, model.solution.message);
        if (status == core::SolutionStatus::ok || message.empty())
            continue;
        const auto same = std::ranges::find(models_of_reason, message, &std::pair<std::string, std::string>::first);
        if (same == models_of_reason.end())
            models_of_reason.emplace_back(message, model.name);
        else
            same->second += ", " + model.name;
    }
    std::string text;
    for (const auto &[reason, names] : models_of_reason)
        text += fmt::format("; {}: {}", names, reason);
    return text;
}

/// Body, Poisson's ratio and load case, in words.
std::string place_of_result(const Result &result) {
    return fmt::format("{}, nu {:g}, {}", result.problem.body->name, poisson_ratio(result),
                       result.problem.load_case.name);
}

} // namespace

std::string reference_of(const Result &result) {
    const auto found =
        std::ranges::find_if(result.models, [](const ModelResult &model) { return model.comparison.has_value(); });
    return found == result.models.end() ? "" : found->comparison->reference;
}

double compared_part(const Result &result) {
    const auto found =
        std::ranges::find_if(result.models, [](const ModelResult &model) { return model.comparison.has_value(); });
    return found == result.models.end() ? 1.0 : found->comparison->load_fraction;
}

bool is_reference_on_mesh(const Result &result) {
    const auto name = reference_of(result);
    return !name.empty() && !(has_known_uncertainty(result) && result.reference_uncertainty->refined == name);
}

std::vector<std::vector<Result>> groups_by_reference(std::span<const Result> results) {
    std::vector<std::vector<Result>> groups;
    for (const auto regime : {core::Regime::small, core::Regime::large}) {
        std::vector<std::string> names;
        std::vector<std::vector<Result>> regime_groups;
        bool has_any = false;
        for (const auto &result : results) {
            if (result.problem.load_case.regime != regime)
                continue;
            has_any = true;
            if (const auto name = reference_of(result); !name.empty() && std::ranges::find(names, name) == names.end())
                names.push_back(name);
        }
        if (names.empty())
            names.emplace_back();
        regime_groups.resize(has_any ? names.size() : 0);
        for (const auto &result : results) {
            if (result.problem.load_case.regime != regime)
                continue;
            const auto at = std::ranges::find(names, reference_of(result)) - names.begin();
            regime_groups[at == std::ssize(names) ? 0 : at].push_back(result);
        }
        std::ranges::move(regime_groups, std::back_inserter(groups));
    }
    return groups;
}

std::string reference_sentence(std::span<const Result> results) {
    const Result *compared = nullptr;
    bool is_known = true;
    for (const auto &result : results)
        if (!reference_of(result).empty()) {
            compared = compared ? compared : &result;
            is_known = is_known && has_known_uncertainty(result);
        }
    if (!compared && !results.empty() && std::ranges::all_of(results, is_reference_alone))
        return fmt::format(
            "Nothing is compared, because {} is the reference itself and no other model was run; name one "
            "with --model.",
            results.front().models.front().name);
    if (!compared)
        return "Nothing is compared, because no reference has a solution.";
    return fmt::format("Errors are against {}, which was solved on {}; {}.", reference_of(*compared),
                       is_reference_on_mesh(*compared) ? "the mesh of the models itself" : "refined meshes",
                       is_known ? "+- is its own uncertainty" : "its own error is not known");
}

double peak_of_reference(const Result &result) {
    const auto found = std::ranges::find(result.models, reference_of(result), &ModelResult::name);
    return found == result.models.end() ? 0.0 : largest_length(found->solution.displacement);
}

double largest_small_displacement(const core::Problem &problem) {
    return std::max(farthest_beyond_target * problem.load_case.target_peak_displacement,
                    largest_small_part * core::extent(problem.body->mesh.points));
}

bool leaves_regime(const Result &result) {
    const auto &load_case = result.problem.load_case;
    if (load_case.regime != core::Regime::small || !(load_case.target_peak_displacement > 0.0))
        return false;
    return peak_of_reference(result) > largest_small_displacement(result.problem);
}

bool ends_at_rest(const Result &result) {
    return std::ranges::any_of(result.models, [](const ModelResult &model) {
        return model.comparison && model.solution.status == core::SolutionStatus::ok &&
               std::isnan(model.comparison->relative_l2);
    });
}

bool counts_in_means(const Result &result) {
    return is_plain_static(result) && !reference_of(result).empty() && !leaves_regime(result) &&
           !ends_at_rest(result) && compared_part(result) == 1.0;
}

std::vector<std::string> counted_load_cases(std::span<const Result> results, const std::string &body, double ratio) {
    std::set<std::string> names;
    for (const auto &result : results)
        if (result.problem.body->name == body && poisson_ratio(result) == ratio && counts_in_means(result))
            names.insert(result.problem.load_case.name);
    return {names.begin(), names.end()};
}

std::vector<CountedCase> counted_cases(std::span<const Result> results, const std::string &body, double ratio,
                                       const std::string &model) {
    std::map<std::string, CountedCase> last;
    for (const auto &result : results) {
        if (result.problem.body->name != body || poisson_ratio(result) != ratio || !counts_in_means(result))
            continue;
        const auto found = std::ranges::find(result.models, model, &ModelResult::name);
        if (found != result.models.end())
            last[result.problem.load_case.name] = {&*found, &result};
    }
    std::vector<CountedCase> cases;
    for (const auto &[name, counted] : last)
        cases.push_back(counted);
    return cases;
}

std::string shown_status(const ModelResult &model, const Result &result) {
    if (model.solution.status != core::SolutionStatus::ok)
        return core::to_string(model.solution.status);
    if (is_reference_alone(result))
        return "reference";
    if (reference_of(result).empty())
        return "not compared";
    if (ends_at_rest(result))
        return result.problem.load_case.is_touched() ? "nothing touches" : "at rest";
    if (const double part = compared_part(result); part < 1.0)
        return fmt::format("ok to {:.3g} %", core::percent * part);
    return leaves_regime(result) ? "out of regime" : "ok";
}

std::vector<std::string> result_remarks(std::span<const Result> results) {
    std::vector<std::string> remarks;
    for (const auto &result : results)
        if (is_reference_alone(result))
            remarks.push_back(fmt::format("{}: {} is the reference, and no other model is there to compare with it",
                                          place_of_result(result), result.models.front().name));
        else if (reference_of(result).empty() && !result.models.empty())
            remarks.push_back(fmt::format("{}: no reference has a solution, so no model is compared{}",
                                          place_of_result(result), reasons(result)));
        else if (ends_at_rest(result))
            remarks.push_back(
                fmt::format("{}: {}, where {} is at rest, so there are no ratios and no model is ranked; {}",
                            place_of_result(result),
                            result.problem.load_case.is_touched() ? "nothing touches at the end"
                                                                  : "nothing moves the body at the end",
                            reference_of(result),
                            result.problem.load_case.is_touched() ? "give a shorter 'slide' or a larger 'depth'"
                                                                  : "give a load that stays"));
        else if (const double part = compared_part(result); part < 1.0)
            remarks.push_back(fmt::format("{}: models are compared at {:.3g} % of the load, the last point of the path "
                                          "with a reference, and count in no mean{}",
                                          place_of_result(result), core::percent * part, reasons(result)));
        else if (leaves_regime(result))
            remarks.push_back(fmt::format(
                "{} moves {:.3g} mm where {:.3g} mm were meant: small deformations end before that, so its errors "
                "count "
                "in no mean; give a smaller load, 'scale_to_target = true', or a load case of the large regime",
                place_of_result(result), core::millimetres * peak_of_reference(result),
                core::millimetres * result.problem.load_case.target_peak_displacement));
    return remarks;
}

} // namespace livermark::results
