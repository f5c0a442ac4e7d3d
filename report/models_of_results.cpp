#include "report/models_of_results.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "results/tables/overview.hpp"

namespace livermark::report {

namespace {

template <class T> void note(std::vector<T> &seen, const T &value) {
    if (std::ranges::find(seen, value) == seen.end())
        seen.push_back(value);
}

bool is_finite_elements(const std::string &model) {
    return model.starts_with("fem_");
}

} // namespace

std::vector<std::string> body_labels(std::span<const results::Result> results) {
    std::vector<std::string> labels;
    for (const auto &result : results)
        note(labels, results::body_label(result, results));
    return labels;
}

std::vector<std::string> model_names(std::span<const results::Result> results) {
    std::vector<std::string> names;
    for (const auto &result : results)
        for (const auto &model : result.models)
            note(names, model.name);
    return names;
}

std::string reference_of(const results::Result &result) {
    for (const auto &model : result.models)
        if (model.comparison)
            return model.comparison->reference;
    return {};
}

const results::ModelResult *find_model(const results::Result &result, const std::string &name) {
    const auto found = std::ranges::find(result.models, name, &results::ModelResult::name);
    return found == result.models.end() ? nullptr : &*found;
}

double error_of(const results::ModelResult &model) {
    return model.solution.status == core::SolutionStatus::ok && model.comparison
               ? model.comparison->relative_l2
               : std::numeric_limits<double>::quiet_NaN();
}

bool is_spring_model(const results::ModelResult &model) {
    return model.solution.springs || model.solution.explicit_steps;
}

const results::ModelResult *best_spring_model(const results::Result &result) {
    const results::ModelResult *best = nullptr;
    for (const auto &model : result.models)
        if (is_spring_model(model) && std::isfinite(error_of(model)) && (!best || error_of(model) < error_of(*best)))
            best = &model;
    return best;
}

SeriesStyle style_of(const std::string &model, const std::vector<std::string> &all) {
    constexpr std::array greys{"#111111", "#555555", "#888888", "#aaaaaa"};
    // Okabe and Ito's colours without the yellow, which is too light for lines on white.
    constexpr std::array colours{"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"};
    constexpr std::array markers{Marker::circle, Marker::diamond, Marker::triangle};
    std::size_t place = 0;
    for (const auto &other : all) {
        if (other == model)
            break;
        place += is_finite_elements(other) == is_finite_elements(model) ? 1 : 0;
    }
    if (is_finite_elements(model))
        return {.colour = greys[place % greys.size()], .marker = Marker::square};
    return {.colour = colours[place % colours.size()], .marker = markers[place / colours.size() % markers.size()]};
}

double mean(const std::vector<double> &values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

std::vector<std::string> commands_of(std::span<const results::Result> results) {
    std::vector<std::string> commands;
    for (const auto &result : results)
        note(commands, result.provenance.command);
    return commands;
}

} // namespace livermark::report
