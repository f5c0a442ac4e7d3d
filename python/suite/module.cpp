#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <mutex>
#include <stdexcept>
#include <utility>

#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/support/processes/own_process.hpp"
#include "meshes/cutting/cut_reader.hpp"
#include "meshes/io/body_reader.hpp"
#include "python/bindings/arrays.hpp"
#include "python/bindings/interpreter.hpp"
#include "python/suite/problem.hpp"
#include "results/hdf5/result_file.hpp"
#include "results/one_reference.hpp"
#include "results/records/result.hpp"
#include "studies/advise/advise.hpp"
#include "studies/exchange/exchange.hpp"
#include "studies/models/model_table.hpp"
#include "studies/study.hpp"

namespace livermark::python {

namespace {

/// A comparison with the reference, and those of the models beside it.
struct Scored {
    std::string name;
    results::Result result;

    const results::ModelResult &model() const {
        return *std::ranges::find(result.models, name, &results::ModelResult::name);
    }
    const core::Comparison &comparison() const { return *model().comparison; }
};

/// Scores read and write result files, and HDF5 works for one thread at a time. Looked at by the thread that holds the
/// interpreter.
class RunningScores {
  public:
    RunningScores() {
        if (forks_ != support::fork_count() && num_running_ > 0)
            throw std::runtime_error(
                "this process was forked while another thread computed a score, and HDF5 cannot go "
                "on in it; start processes by the method 'spawn' of multiprocessing");
        forks_ = support::fork_count();
        ++num_running_;
    }
    ~RunningScores() { --num_running_; }
    RunningScores(const RunningScores &) = delete;
    RunningScores &operator=(const RunningScores &) = delete;

  private:
    static inline int num_running_ = 0;
    static inline unsigned forks_ = support::fork_count();
};

results::Result compared(const LoadedBody &loaded, const std::vector<core::Vector3> &displacement,
                         const studies::ScoreOptions &options, const std::optional<std::string> &output) {
    const std::lock_guard lock(support::mutex_of_process<RunningScores>());
    auto result = studies::score_displacement(loaded.problem, displacement, options, "livermark.score()", {});
    if (!std::ranges::find(result.models, options.name, &results::ModelResult::name)->comparison)
        throw std::runtime_error("the reference found no solution, so nothing can be compared");
    if (output)
        results::write_result(*output, result);
    return result;
}

Scored score(const LoadedBody &loaded, const py::object &displacement, const std::string &name,
             const std::vector<std::string> &models, bool reference_on_mesh, const std::optional<std::string> &output,
             const py::object &with_uncertainty) {
    if (!with_uncertainty.is_none())
        throw support::InputError("with_uncertainty is now reference_on_mesh, its opposite, because errors are then "
                                  "against another reference; write reference_on_mesh=True for with_uncertainty=False");
    const auto given = to_vectors(displacement, "displacement", loaded.problem.body->mesh.points.size());
    const studies::ScoreOptions options{.body = loaded.problem.body->name,
                                        .load_case = loaded.problem.load_case.name,
                                        .solution = "an array",
                                        .name = name,
                                        .models = models,
                                        .output = {},
                                        .reference_on_mesh = reference_on_mesh};
    const RunningScores running;
    Scored scored{name, without_interpreter([&] { return compared(loaded, given, options, output); })};
    for (const auto &doubt : studies::doubts_about_sign(scored.result, name))
        if (PyErr_WarnEx(PyExc_UserWarning, doubt.c_str(), 1) != 0)
            throw py::error_already_set();
    return scored;
}

/// Relative errors of the models beside it.
py::dict errors_of_models(const Scored &scored) {
    py::dict errors;
    for (const auto &model : scored.result.models)
        if (model.comparison)
            errors[py::str(model.name)] = model.comparison->relative_l2;
    return errors;
}

std::vector<std::string> stems(const char *folder, const char *word) {
    std::vector<std::string> names;
    for (const auto &file : studies::find_toml_files({}, folder, word))
        names.push_back(file.stem().string());
    return names;
}

/// Attributes of the program that wrote a file, see "Where it comes from" in results/schema.md.
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

std::string advise_on(const core::Body &body, const studies::AdviceOptions &options) {
    return studies::to_json(studies::advise(body, options, {}));
}

std::string advise_on_file(const std::string &body, std::optional<double> young_modulus,
                           std::optional<double> poisson_ratio, double tool_radius, std::optional<double> budget) {
    return without_interpreter([&] {
        const auto file = studies::find_toml_files({body}, studies::bodies_folder, "body").front();
        const bool is_mesh = support::file_ending(file) != ".toml";
        return advise_on(meshes::read_body(file, {young_modulus, poisson_ratio}),
                         {.tool_radius = tool_radius,
                          .budget = budget,
                          .is_material_assumed = is_mesh && !young_modulus.has_value()});
    });
}

std::string advise_on_arrays(const py::object &points, const py::object &tetrahedra, const py::object &young_modulus,
                             const py::object &poisson_ratio, const py::object &density, double tool_radius,
                             std::optional<double> budget, bool is_material_assumed) {
    const auto body = to_body(points, tetrahedra, young_modulus, poisson_ratio, density);
    return without_interpreter([&] {
        return advise_on(body,
                         {.tool_radius = tool_radius, .budget = budget, .is_material_assumed = is_material_assumed});
    });
}

using meshes::CutBody;

CutBody cut_body(const std::string &body, const meshes::CutWords &words, const std::optional<std::string> &output) {
    return without_interpreter([&] {
        const auto cut = meshes::cut_of(words, "livermark.cut()");
        auto result = meshes::cut(
            meshes::read_body(studies::find_toml_files({body}, studies::bodies_folder, "body").front()), cut);
        if (output)
            meshes::write_cut_body(*output, result, "livermark.cut()");
        return result;
    });
}

} // namespace

void add_score(py::module_ &module, py::class_<LoadedBody> &problem) {
    const auto number = [](double core::Comparison::*value) {
        return [=](const Scored &s) { return s.comparison().*value; };
    };
    py::class_<Scored>(module, "Score", "How far a displacement is from the reference.")
        .def_readonly("name", &Scored::name, "of the model")
        .def_property_readonly(
            "reference", [](const Scored &s) { return s.comparison().reference; }, "name of the reference")
        .def_property_readonly(
            "reference_on_mesh", [](const Scored &s) { return results::is_reference_on_mesh(s.result); },
            "whether the reference was solved on the mesh itself, not on refined meshes")
        .def_property_readonly("relative_l2", number(&core::Comparison::relative_l2),
                               "sqrt(sum V_i |u_i - r_i|^2 / sum V_i |r_i|^2), V_i the volume of node i")
        .def_property_readonly(
            "stiffness_at_tool",
            [](const Scored &s) {
                const auto &tool = s.comparison().tool;
                return tool && !std::isnan(tool->stiffness()) ? std::optional(tool->stiffness()) : std::nullopt;
            },
            "force over displacement where the load case presses, pulls or moves a place, over that of the reference, "
            "minus 1;\npositive is too stiff; None without such a place, and where a depth or displacement is given")
        .def_property_readonly("max_error", number(&core::Comparison::max_error), "largest |u_i - r_i| [m]")
        .def_property_readonly("max_error_relative", number(&core::Comparison::max_error_relative),
                               "max_error over the largest |r_i|")
        .def_property_readonly(
            "uncertainty",
            [](const Scored &s) {
                const auto &known = s.result.reference_uncertainty;
                return known ? std::optional(known->relative_l2) : std::nullopt;
            },
            "what relative_l2 of the reference itself is estimated to be; None where that was not found")
        .def_property_readonly(
            "within_uncertainty", [](const Scored &s) { return results::is_within_uncertainty(s.model(), s.result); },
            "closer to the reference than that is known to be: not to be ranked above another such model")
        .def_property_readonly(
            "error", [](const Scored &s) { return to_array(s.comparison().error); }, "(N, 3) u - r [m]")
        .def_property_readonly("relative_l2_of_models", &errors_of_models,
                               "dict from each compared model, this one too, to its relative_l2")
        .def("__repr__", [](const Scored &s) {
            return fmt::format("<livermark.Score {}: {:.2f} % off {}>", s.name, 100.0 * s.comparison().relative_l2,
                               s.comparison().reference);
        });
    problem.def(
        "score", &score, py::arg("displacement"), py::arg("name") = "mine",
        py::arg("models") = std::vector<std::string>{models::baseline_name()}, py::kw_only(),
        py::arg("reference_on_mesh") = false, py::arg("output") = py::none(), py::arg("with_uncertainty") = py::none(),
        "Compares displacements of the nodes with the reference, which it solves.\n\n"
        "displacement: (N, 3) [m]. name: of the model. models: to compare beside it. reference_on_mesh: compare "
        "with the\nreference on the mesh itself, not on refined meshes: quicker, but its own error stays "
        "unknown. output: path of a\nresult file to write. with_uncertainty: is refused, it was the opposite "
        "of reference_on_mesh. Returns Score.\nRaises InputError.");
}

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

void add_advise(py::module_ &module) {
    module.def("_advise_on_file", &advise_on_file, py::arg("body"), py::arg("young_modulus"), py::arg("poisson_ratio"),
               py::arg("tool_radius"), py::arg("budget"), "JSON of livermark.advise() for a body by name or path.");
    module.def("_advise_on_arrays", &advise_on_arrays, py::arg("points"), py::arg("tetrahedra"),
               py::arg("young_modulus"), py::arg("poisson_ratio"), py::arg("density"), py::arg("tool_radius"),
               py::arg("budget"), py::arg("is_material_assumed"), "JSON of livermark.advise() for arrays.");
}

void add_cut(py::module_ &module) {
    py::class_<CutBody> cut(module, "CutBody",
                            "What a cut leaves of a body. Arrays are views that cannot be written to.");
    add_mesh(cut, [](const CutBody &c) -> const core::TetraMesh & { return c.body.mesh; });
    cut.def_property_readonly("parent_tetrahedron",
                              read_only<CutBody, int>([](const CutBody &c) { return &c.parents.front(); }, 1),
                              "(M) the tetrahedron before the cut that each is, or is a part of")
        .def_readonly("volume_before", &CutBody::volume_before, "[m^3]")
        .def_readonly("removed_volume", &CutBody::removed_volume, "[m^3]")
        .def_readonly("removed_mass", &CutBody::removed_mass, "[kg]")
        .def_readonly("wound_area", &CutBody::wound_area, "[m^2]")
        .def_property_readonly(
            "num_small_pieces", [](const CutBody &c) { return c.small_pieces.size(); },
            "how many are bodies of their own, with small_pieces='keep'")
        .def_readonly("notes", &CutBody::notes, "sentences on what was taken away")
        .def("__repr__", [](const CutBody &c) {
            return fmt::format("<livermark.CutBody {} of {} tetrahedra>", c.body.name, c.body.mesh.num_tetrahedra());
        });
    module.def(
        "cut",
        [](const std::string &body, std::optional<std::string> region, std::optional<double> margin,
           std::vector<double> half_space, std::vector<double> blade, std::optional<double> thickness, std::string way,
           std::string small_pieces, const std::optional<std::string> &output) {
            return cut_body(body,
                            {std::move(region), margin, std::move(half_space), std::move(blade), thickness,
                             std::move(way), std::move(small_pieces)},
                            output);
        },
        py::arg("body"), py::arg("region"), py::arg("margin"), py::arg("half_space"), py::arg("blade"),
        py::arg("thickness"), py::arg("way"), py::arg("small_pieces"), py::arg("output"),
        "Cuts a body at rest, see livermark.cut(), whose arguments these are.");
}

} // namespace livermark::python

/// Problems, models and the reference: the whole suite, with deal.II and CHOLMOD behind it.
PYBIND11_MODULE(_suite, module) {
    module.doc() = "Problems, solutions and scores of Livermark; import livermark instead.";
    livermark::python::translate_input_errors();
    livermark::python::work_at_the_end::register_with();
    livermark::python::add_problem(module);
    livermark::python::add_advise(module);
    livermark::python::add_catalogue(module);
    livermark::python::add_cut(module);
}
