#include "app/problems.hpp"

#include <fmt/format.h>
#include <memory>
#include <optional>

#include "app/catalogue.hpp"
#include "app/load_scaling.hpp"
#include "core/input_error.hpp"
#include "fem_reference/mpi_session.hpp"
#include "load_cases/load_case_reader.hpp"
#include "load_cases/selector.hpp"

namespace livermark::app {

std::vector<core::Problem> read_problems(const std::vector<std::string> &bodies,
                                         const std::vector<std::string> &load_cases,
                                         const meshes::MaterialOverride &material) {
    const bool is_asked_for = !bodies.empty() && !load_cases.empty();
    std::vector<core::Problem> problems;
    std::optional<std::string> fault;
    std::string passed_over, assumed;
    const auto load_case_files = find_toml_files(load_cases, load_cases_folder, "load case");
    for (const auto &body_file : find_toml_files(bodies, bodies_folder, "body")) {
        const auto body = std::make_shared<const core::Body>(meshes::read_body(body_file, material));
        for (const auto &assumption : body->assumptions)
            assumed += fmt::format("livermark: {}: {}\n", body->name, assumption);
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
            passed_over +=
                fmt::format("livermark: passed over on {}, which lacks patches, regions or places of theirs: {}\n",
                            body->name, fmt::join(unfit, ", "));
    }
    if (problems.empty())
        throw core::InputError(fault.value());
    if (fem_reference::mpi_rank() == 0)
        fmt::print(stderr, "{}{}", assumed, passed_over);
    return problems;
}

std::vector<core::Problem> read_scaled_problems(const std::vector<std::string> &bodies, const std::string &load_case,
                                                const meshes::MaterialOverride &material) {
    auto problems = read_problems(bodies, {load_case}, material);
    for (auto &problem : problems)
        problem = scaled_to_target(std::move(problem));
    return problems;
}

} // namespace livermark::app
