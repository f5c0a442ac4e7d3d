#include "studies/needle/needle_study.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <utility>

#include "load_cases/places/selector.hpp"
#include "load_cases/readers/needle_reader.hpp"
#include "models/model_table.hpp"
#include "results/hdf5/files/needle_file.hpp"
#include "results/provenance.hpp"
#include "studies/catalogue.hpp"
#include "studies/needle/insertion.hpp"
#include "studies/needle/needle_problems.hpp"
#include "studies/run/problems.hpp"
#include "studies/run/solutions/output_folder.hpp"
#include "support/input_error.hpp"
#include "support/known_names.hpp"

namespace livermark::studies {

namespace {

std::vector<core::Model> models_that_know_compliance() {
    auto able = models::all_models();
    std::erase_if(able, [](const core::Model &model) { return !model.compliance; });
    return able;
}

} // namespace

core::Model needle_reference_model(bool on_mesh) {
    const auto judge = models::static_reference(core::Regime::small);
    return support::find_named(models_that_know_compliance(), on_mesh ? judge.on_mesh : judge.refined,
                               "model that a needle can be driven into");
}

std::vector<core::Model> models_with_needles(const NeedleOptions &options) {
    const auto able = models_that_know_compliance();
    std::vector<core::Model> chosen{needle_reference_model(options.reference_on_mesh)};
    const auto add = [&](const core::Model &model) {
        if (std::ranges::find(chosen, model.name, &core::Model::name) == chosen.end())
            chosen.push_back(model);
    };
    for (const auto &name : options.models)
        add(support::find_named(able, name, "model that a needle can be driven into"));
    if (options.models.empty())
        for (const auto &model : able)
            if (!model.only_when_named && model.at_rest != core::Role::refined_reference &&
                model.only != core::Regime::large)
                add(model);
    return chosen;
}

std::vector<NeedleProblem> read_with_needles(const NeedleOptions &options, std::vector<std::string> &notes) {
    const auto file = find_toml_files({options.load_case}, needle_load_cases_folder, "load case").front();
    auto set = read_needle_problems(options.bodies, file.string(), options.material);
    notes = std::move(set.notes);
    std::vector<NeedleProblem> problems;
    std::string fault;
    for (auto &problem : set.problems)
        try {
            auto needles = load_cases::read_needles(file, *problem.body, problem.load_case);
            problems.push_back({std::move(problem), std::move(needles)});
        } catch (const load_cases::NotOnBody &error) {
            notes.push_back(fmt::format("left out on {}: {}, because {}", problem.body->name, file.stem().string(),
                                        error.reason()));
            fault = error.what();
        }
    if (problems.empty())
        throw support::InputError(fault);
    return problems;
}

namespace {

results::NeedleStudy drive(const core::Problem &problem, const core::Needle &needle,
                           const std::vector<core::Model> &models, Steps &steps) {
    const auto line = core::needle_line(needle);
    results::NeedleStudy study{.needle = needle, .runs = {}};
    for (const auto &model : models) {
        steps.next(fmt::format("{} / {} / {}", problem.body->name, needle.name, model.name));
        const auto compliance = model.compliance(problem, line.places);
        study.runs.push_back({model.name, insert(compliance.matrix, line, needle), compliance.seconds});
        if (study.runs.size() > 1 || compliance.on_coarser.empty())
            continue;
        const results::NeedleRun coarser{model.name, insert(compliance.on_coarser.back(), line, needle)};
        study.reference_miss_change = (study.runs.front().miss() - coarser.miss()).norm();
        study.reference_force_change = results::force_error(coarser.insertion, study.runs.front().insertion);
    }
    return study;
}

} // namespace

NeedleResults drive_needles(const NeedleOptions &options, const std::string &command_line,
                            const ProgressReport &report) {
    const auto models = models_with_needles(options);
    NeedleResults done;
    const auto problems = read_with_needles(options, done.notes);
    std::size_t num_needles = 0;
    for (const auto &[problem, needles] : problems)
        num_needles += needles.size();
    Steps steps(static_cast<int>(num_needles * models.size()), report);
    for (const auto &[problem, needles] : problems) {
        const auto folder = make_output_folder(options.output, problem);
        results::NeedleFile file{.provenance = results::current_provenance(command_line),
                                 .body = problem.body->name,
                                 .load_case = problem.load_case.name,
                                 .title = problem.load_case.title,
                                 .needles = {}};
        for (const auto &needle : needles)
            file.needles.push_back(drive(problem, needle, models, steps));
        results::write_needles(folder / fmt::format("needle.{}.h5", problem.load_case.name), file);
        done.of_body.push_back(std::move(file));
    }
    return done;
}

} // namespace livermark::studies
