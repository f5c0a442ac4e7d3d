#include <fmt/format.h>
#include <memory>
#include <string>
#include <vector>

#include "app/cli/commands/commands.hpp"
#include "app/cli/common_options.hpp"
#include "core/support/input_error.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "meshes/io/body_reader.hpp"
#include "msm/integrator.hpp"
#include "msm/spring_law.hpp"
#include "studies/files.hpp"
#include "studies/models/model_table.hpp"
#include "studies/models/motion/moving_method.hpp"

namespace livermark::cli {

namespace {

void print_entry(const std::string &name, const std::string &text) {
    fmt::print("{:<24} {}\n", name, text);
}

void list_bodies() {
    for (const auto &file : studies::find_toml_files({}, studies::bodies_folder, "body"))
        print_entry(file.stem().string(), meshes::body_title(file));
}

void list_load_cases_in(const char *folder) {
    for (const auto &file : studies::find_toml_files({}, folder, "load case"))
        print_entry(file.stem().string(), load_cases::load_case_title(file));
}

void list_models() {
    for (const auto &model : models::all_models())
        print_entry(model.name, fmt::format("{} [{}]", model.summary, model.source));
}

void list_spring_laws() {
    for (const auto &law : msm::all_spring_laws())
        print_entry(law.name, fmt::format("{} [{}]", law.summary, law.source));
}

void list_methods() {
    for (const auto &method : models::all_moving_methods())
        print_entry(method.name, fmt::format("{} [{}]", method.implementation, method.source));
}

void list_integrators() {
    for (const auto &integrator : msm::known_integrators())
        print_entry(integrator.name, fmt::format("{} [{}]", integrator.summary, integrator.source));
}

struct List {
    std::string name;
    void (*print)();
};

const std::vector<List> &lists() {
    static const std::vector<List> table{
        {"bodies", list_bodies},
        {"load-cases", [] { list_load_cases_in(studies::load_cases_folder); }},
        {"moving-load-cases", [] { list_load_cases_in(studies::moving_load_cases_folder); }},
        {"touching-load-cases", [] { list_load_cases_in(studies::touching_load_cases_folder); }},
        {"needle-load-cases", [] { list_load_cases_in(studies::needle_load_cases_folder); }},
        {"slow-load-cases", [] { list_load_cases_in(studies::slow_load_cases_folder); }},
        {"models", list_models},
        {"methods", list_methods},
        {"spring-laws", list_spring_laws},
        {"integrators", list_integrators}};
    return table;
}

} // namespace

Command add_list(CLI::App &parent) {
    auto *command = parent.add_subcommand(
        "list", "List bodies, load cases (also those with a moving or touching tool, with a needle, or of tissue that "
                "relaxes), models, methods of the arena, spring laws or integrators");
    auto what = std::make_shared<std::string>();
    const auto names = support::names_of(lists());
    command->add_option("what", *what, fmt::format("One of {}", fmt::join(names, ", ")))
        ->required()
        ->check(one_of(names));
    return [what] {
        support::find_named(lists(), CLI::detail::to_lower(*what), "list").print();
        return 0;
    };
}

} // namespace livermark::cli
