#include "app/problems.hpp"

#include <fmt/format.h>
#include <memory>

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
    std::vector<std::string> passed_over;
    const auto load_case_files = find_toml_files(load_cases, load_cases_folder, "load case");
    for (const auto &body_file : find_toml_files(bodies, bodies_folder, "body")) {
        const auto body = std::make_shared<const core::Body>(meshes::read_body(body_file, material));
        for (const auto &load_case_file : load_case_files) {
            try {
                problems.push_back({body, load_cases::read_load_case(load_case_file, body->mesh)});
            } catch (const load_cases::NotOnBody &error) {
                if (is_asked_for)
                    throw;
                passed_over.push_back(
                    fmt::format("{} / {}: {}", body->name, load_case_file.stem().string(), error.what()));
            }
        }
    }
    if (problems.empty())
        throw core::InputError(passed_over.front());
    if (fem_reference::mpi_rank() == 0)
        for (const auto &reason : passed_over)
            fmt::print(stderr, "livermark: passed over: {}\n", reason);
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
