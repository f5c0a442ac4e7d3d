#include "results/tables/brief.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <set>
#include <utility>
#include <vector>

#include "core/units.hpp"
#include "results/one_reference.hpp"
#include "results/tables/overview.hpp"
#include "results/tables/tool_cells.hpp"

namespace livermark::results {

namespace {

/// A body at a Poisson's ratio.
struct BriefBody {
    std::string name;
    double poisson_ratio;
    std::string label;
};

std::vector<BriefBody> brief_bodies(std::span<const Result> results) {
    std::vector<BriefBody> bodies;
    std::set<std::string> known;
    for (const auto &result : results)
        if (counts_in_means(result))
            if (auto label = body_label(result, results); known.insert(label).second)
                bodies.push_back({result.problem.body->name, poisson_ratio(result), std::move(label)});
    return bodies;
}

/// In the order in which they appear, each once.
std::vector<std::string> brief_models(std::span<const Result> results) {
    std::vector<std::string> models;
    for (const auto &[body, model] : bodies_and_models(results, counts_in_means))
        if (std::ranges::find(models, model) == models.end())
            models.push_back(model);
    return models;
}

/// "nodal_springs 4.9 and 4.0 %, ..."
std::string listed(const BestSprings &best) {
    std::string text;
    for (const auto &[body, model, numbers] : best.models)
        text += fmt::format("{}{} {}{} %", text.empty() ? "" : ", ", model,
                            best.has_tools ? fixed(core::percent * numbers.median_stiffness, 1) + " and " : "",
                            fixed(core::percent * numbers.median_error, 1));
    return text;
}

} // namespace

std::vector<BriefNumbers> brief_numbers(std::span<const Result> results) {
    std::vector<BriefNumbers> all;
    const auto bodies = brief_bodies(results);
    if (bodies.empty())
        return all;
    const auto models = brief_models(results);
    for (const auto &body : bodies)
        for (const auto &model : models)
            all.push_back({body.label, model, two_numbers(results, body.name, body.poisson_ratio, model)});
    return all;
}

Layout brief(std::span<const Result> results) {
    const auto bodies = brief_bodies(results);
    Layout layout{{{"model"}}, {}};
    for (const auto &body : bodies) {
        layout.columns.push_back({body.label + ": L2 [%]", true});
        layout.columns.push_back({"tool [%]", true});
    }
    if (bodies.empty())
        return layout;
    for (const auto &model : brief_models(results)) {
        auto &row = layout.rows.emplace_back(std::vector{model});
        for (const auto &body : bodies) {
            auto numbers = two_numbers(results, body.name, body.poisson_ratio, model);
            row.push_back(std::move(numbers.error));
            row.push_back(std::move(numbers.stiffness));
        }
    }
    return layout;
}

std::vector<BestSprings> best_springs(std::span<const Result> results) {
    constexpr std::size_t most = 3;
    std::vector<BestSprings> all;
    const auto numbers = brief_numbers(results);
    for (const auto &body : brief_bodies(results)) {
        BestSprings best{.body = body.label, .models = {}};
        for (const auto &one : numbers)
            if (one.body == body.label && one.numbers.is_spring_model) {
                best.models.push_back(one);
                best.has_tools = best.has_tools || !std::isnan(one.numbers.median_stiffness);
            }
        const auto larger = [&](const BriefNumbers &one) { return one.numbers.larger(best.has_tools); };
        std::erase_if(best.models, [&](const BriefNumbers &one) { return std::isnan(larger(one)); });
        std::ranges::stable_sort(best.models, {}, larger);
        best.models.erase(best.models.begin() + static_cast<std::ptrdiff_t>(std::min(best.models.size(), most)),
                          best.models.end());
        if (!best.models.empty())
            all.push_back(std::move(best));
    }
    return all;
}

std::string brief_legend(std::span<const Result> results) {
    std::string text =
        "L2: error of the displacement over the whole body; both numbers are medians over load cases, of "
        "absolute values, and the tool has a sign where all load cases have the same\n" +
        tool_legend();
    for (const auto &best : best_springs(results))
        text += fmt::format("best springs on {}{}: {}\n", best.body,
                            best.has_tools ? ", by the larger of both numbers, under the tool and in position"
                                           : ", in position",
                            listed(best));
    return text;
}

} // namespace livermark::results
