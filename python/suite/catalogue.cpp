#include "studies/catalogue.hpp"

#include "models/model_table.hpp"
#include "python/suite/problem.hpp"

namespace livermark::python {

namespace {

std::vector<std::string> stems(const char *folder, const char *word) {
    std::vector<std::string> names;
    for (const auto &file : studies::find_toml_files({}, folder, word))
        names.push_back(file.stem().string());
    return names;
}

} // namespace

void add_catalogue(py::module_ &module) {
    module.def(
        "bodies", [] { return stems(studies::bodies_folder, "body"); }, "Names of the bodies that ship.");
    module.def(
        "load_cases", [] { return stems(studies::load_cases_folder, "load case"); },
        "Names of the load cases that ship.");
    module.def(
        "models",
        [] {
            std::vector<std::string> names;
            for (const auto &model : models::all_models())
                names.push_back(model.name);
            return names;
        },
        "Names of the models.");
}

} // namespace livermark::python
