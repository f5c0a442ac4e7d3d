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

/// "nodal_springs 3.1 %, ..." of the three smallest.
std::string best_three(std::vector<std::pair<double, std::string>> models) {
    std::erase_if(models, [](const auto &model) { return std::isnan(model.first); });
    std::ranges::sort(models);
    models.resize(std::min<std::size_t>(models.size(), 3));
    std::string text;
    for (const auto &[value, name] : models)
        text += fmt::format("{}{} {} %", text.empty() ? "" : ", ", name, fixed(core::percent * value, 1));
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

std::string brief_legend(std::span<const Result> results) {
    std::string text =
        "L2: error of the displacement over the whole body; both numbers are medians over load cases\n" + tool_legend();
    const auto all = brief_numbers(results);
    for (const auto &body : brief_bodies(results)) {
        std::vector<std::pair<double, std::string>> by_error, by_stiffness;
        for (const auto &[label, model, numbers] : all)
            if (label == body.label && numbers.is_spring_model) {
                by_error.emplace_back(numbers.median_error, model);
                by_stiffness.emplace_back(numbers.median_stiffness, model);
            }
        const auto stiffest = best_three(std::move(by_stiffness)), nearest = best_three(std::move(by_error));
        if (!nearest.empty())
            text += fmt::format("best springs on {}: {}{}{}\n", body.label,
                                stiffest.empty() ? "" : "under the tool " + stiffest + "; ", "in position ", nearest);
    }
    return text;
}

} // namespace livermark::results
