#include "models/model_table.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <iterator>

namespace livermark::models {

std::vector<double> ModelOptions::sweep_of(std::string_view constant) const {
    const auto found = sweeps.find(std::string(constant));
    return found == sweeps.end() ? std::vector<double>{} : found->second;
}

std::string swept_name(std::string_view constant, double value) {
    auto name = fmt::format("{}_{}", constant, value);
    std::ranges::replace(name, '.', '_');
    return name;
}

std::vector<core::Model> all_models(const ModelOptions &options) {
    std::vector<core::Model> models;
    for (const auto &family : all_families())
        std::ranges::move(family.models(options), std::back_inserter(models));
    return models;
}

} // namespace livermark::models
