#include "models/model_table.hpp"

#include <algorithm>
#include <iterator>

namespace livermark::models {

std::vector<core::Model> all_models(const ModelOptions &options) {
    std::vector<core::Model> models;
    for (const auto &family : all_families())
        std::ranges::move(family.models(options), std::back_inserter(models));
    return models;
}

} // namespace livermark::models
