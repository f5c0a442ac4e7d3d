#include "studies/run/prepared_models.hpp"

#include <algorithm>
#include <utility>

#include "support/processes/memory.hpp"

namespace livermark::studies {

core::Solution PreparedModels::solve(const core::Model &model, const core::Problem &problem) {
    return std::move(solve(model, std::span(&problem, 1)).front());
}

std::vector<core::Solution> PreparedModels::solve(const core::Model &model, std::span<const core::Problem> problems) {
    std::vector<core::LoadCase> load_cases;
    for (const auto &problem : problems)
        load_cases.push_back(problem.load_case);
    return on(model, problems.front().body).solve(load_cases);
}

void PreparedModels::clear() {
    if (prepared_.empty())
        return;
    prepared_.clear();
    body_.reset();
    support::return_freed_memory();
}

core::PreparedModel &PreparedModels::on(const core::Model &model, const std::shared_ptr<const core::Body> &body) {
    if (body_ != body) {
        clear();
        body_ = body;
    }
    auto &prepared = prepared_[model.name];
    if (!prepared) {
        const auto common = std::ranges::find(common_, body, &core::Problem::body);
        prepared = model.prepare(body, common != common_.end() ? &common->load_case : nullptr);
    }
    return *prepared;
}

} // namespace livermark::studies
