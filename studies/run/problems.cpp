#include "studies/run/problems.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <iterator>
#include <memory>
#include <optional>

#include "load_cases/load_case_reader.hpp"
#include "load_cases/selector.hpp"
#include "studies/catalogue.hpp"
#include "studies/run/load_scaling.hpp"
#include "support/input_error.hpp"

namespace livermark::studies {

ProblemSet read_problems(const std::vector<std::string> &bodies, const std::vector<std::string> &load_cases,
                         const meshes::MaterialOverride &material) {
    const bool is_asked_for = !bodies.empty() && !load_cases.empty();
    std::vector<core::Problem> problems;
    std::optional<std::string> fault;
    std::vector<std::string> passed_over, notes;
    const auto load_case_files = find_toml_files(load_cases, load_cases_folder, "load case");
    for (const auto &body_file : find_toml_files(bodies, bodies_folder, "body")) {
        const auto body = std::make_shared<const core::Body>(meshes::read_body(body_file, material));
        for (const auto &assumption : body->assumptions)
            notes.push_back(fmt::format("{}: {}", body->name, assumption));
        std::vector<std::string> unfit;
        for (const auto &load_case_file : load_case_files) {
            try {
                problems.push_back({body, load_cases::read_load_case(load_case_file, body->mesh)});
            } catch (const load_cases::NotOnBody &error) {
                if (is_asked_for)
                    throw;
                unfit.push_back(load_case_file.stem().string());
                fault = fault.value_or(error.what());
            }
        }
        if (!unfit.empty())
            passed_over.push_back(fmt::format("passed over on {}, which lacks patches, regions or places of theirs: {}",
                                              body->name, fmt::join(unfit, ", ")));
    }
    if (problems.empty())
        throw support::InputError(fault.value());
    std::ranges::move(passed_over, std::back_inserter(notes));
    return {std::move(problems), std::move(notes)};
}

ProblemSet read_scaled_problems(const std::vector<std::string> &bodies, const std::string &load_case,
                                const meshes::MaterialOverride &material) {
    auto set = read_problems(bodies, {load_case}, material);
    for (auto &problem : set.problems)
        problem = scaled_to_target(std::move(problem));
    return set;
}

} // namespace livermark::studies
