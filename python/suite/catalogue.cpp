#include "studies/files.hpp"

#include "models/model_table.hpp"
#include "python/suite/problem.hpp"
#include "results/provenance.hpp"

namespace livermark::python {

namespace {

std::vector<std::string> stems(const char *folder, const char *word) {
    std::vector<std::string> names;
    for (const auto &file : studies::find_toml_files({}, folder, word))
        names.push_back(file.stem().string());
    return names;
}

/// What a file says of the program that wrote it, see "Where it comes from" in results/schema.md.
py::dict provenance(const std::string &command) {
    const auto found = results::current_provenance(command);
    py::dict attributes;
    attributes["software_version"] = found.software_version;
    attributes["git_commit"] = found.git_commit;
    attributes["created"] = found.created;
    attributes["command"] = found.command;
    attributes["cpu"] = found.cpu;
    attributes["compiler"] = found.compiler;
    attributes["build_type"] = found.build_type;
    attributes["threads"] = found.threads;
    return attributes;
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
    module.def("_provenance", &provenance, py::arg("command"));
}

} // namespace livermark::python
