#include "results/hdf5/files/needle_file.hpp"

#include <fmt/format.h>
#include <string_view>

#include "results/hdf5/file_parts.hpp"
#include "results/hdf5/io/hdf5_io.hpp"
#include "results/hdf5/io/read_apart.hpp"
#include "support/whole_file.hpp"

namespace livermark::results {

namespace {

using hdf5::InputFile;
using hdf5::OutputFile;

constexpr const char *needles_group = "/needles";

/// Calls for each number of a needle with its name.
template <class Needle, class Visit> void for_each_number(Needle &needle, Visit visit) {
    visit("diameter", needle.diameter);
    visit("spread", needle.spread);
    visit("toughness", needle.toughness);
    visit("friction", needle.friction);
    visit("puncture_force", needle.puncture_force);
    visit("step", needle.step);
}

/// Calls for each row of records with its name and its units.
template <class Records, class Visit> void for_each_record(Records &insertion, Visit visit) {
    visit("depth", insertion.depth, "m");
    visit("force", insertion.force, "N");
    visit("tip", insertion.tip, "m");
    visit("target", insertion.target, "m");
    visit("entry", insertion.entry, "m");
    visit("work", insertion.work, "J");
    visit("stored", insertion.stored, "J");
    visit("friction", insertion.friction, "J");
    visit("tearing", insertion.tearing, "J");
    visit("holding", insertion.holding, "J");
}

void write_run(OutputFile &file, const std::string &group, const NeedleRun &run) {
    file.group(group);
    for_each_record(run.insertion, [&](const char *name, const auto &values, const char *units) {
        file.dataset(fmt::format("{}/{}", group, name), values, units);
    });
    file.integer(group, "at_plan", run.insertion.at_plan);
    file.number(group, "puncture_depth", run.insertion.puncture_depth);
    file.number(group, "puncture_loss", run.insertion.puncture_loss);
    file.number(group, "setup_seconds", run.setup_seconds);
}

void write_study(OutputFile &file, const std::string &group, const NeedleStudy &study) {
    file.group(group, true);
    file.text(group, "name", study.needle.name);
    file.dataset(group + "/way", std::vector{study.needle.entry, study.needle.target}, "m");
    for_each_number(study.needle, [&](const char *name, double value) { file.number(group, name, value); });
    file.text(group, "reference", study.runs.front().model);
    file.number(group, "reference_miss_change", study.reference_miss_change);
    file.number(group, "reference_force_change", study.reference_force_change);
    file.group(group + "/models", true);
    for (const auto &run : study.runs)
        write_run(file, fmt::format("{}/models/{}", group, run.model), run);
}

NeedleRun read_run(const InputFile &file, const std::string &group, const std::string &model) {
    NeedleRun run{.model = model, .insertion = {}, .setup_seconds = file.number(group, "setup_seconds")};
    auto &insertion = run.insertion;
    for_each_record(insertion, [&](const char *name, auto &values, const char *) {
        using Value = typename std::remove_cvref_t<decltype(values)>::value_type;
        const auto path = fmt::format("{}/{}", group, name);
        if (std::string_view(name) == "holding" && !file.has(path))
            return; // of an older version
        values =
            insertion.depth.empty() ? file.dataset<Value>(path) : file.dataset<Value>(path, insertion.depth.size());
    });
    const auto at_plan = file.integer(group, "at_plan");
    if (at_plan < 0 || at_plan >= insertion.num_records())
        file.refuse(group, "has an 'at_plan' that is no record");
    insertion.at_plan = static_cast<int>(at_plan);
    insertion.puncture_depth = file.number(group, "puncture_depth");
    insertion.puncture_loss = file.number(group, "puncture_loss");
    return run;
}

NeedleStudy read_study(const InputFile &file, const std::string &group) {
    NeedleStudy study;
    study.needle.name = file.text(group, "name");
    const auto way = file.dataset<core::Vector3>(group + "/way", 2);
    study.needle.entry = way[0];
    study.needle.target = way[1];
    for_each_number(study.needle, [&](const char *name, double &value) { value = file.number(group, name); });
    study.reference_miss_change = file.number(group, "reference_miss_change");
    study.reference_force_change = file.number(group, "reference_force_change");
    for (const auto &model : file.children(group + "/models"))
        study.runs.push_back(read_run(file, fmt::format("{}/models/{}", group, model), model));
    if (study.runs.empty() || study.runs.front().model != file.text(group, "reference"))
        file.refuse(group, "does not begin with its reference");
    for (const auto &run : study.runs)
        if (run.insertion.at_plan != study.runs.front().insertion.at_plan)
            file.refuse(group, "has models with different steps");
    return study;
}

NeedleFile needles_in(const std::filesystem::path &path) {
    const InputFile file(path, "livermark needle");
    hdf5::check_schema(file);
    NeedleFile needles{.provenance = hdf5::read_provenance(file),
                       .body = file.text("/", "body"),
                       .load_case = file.text("/", "load_case"),
                       .title = file.text("/", "title"),
                       .needles = {}};
    for (const auto &name : file.children(needles_group))
        needles.needles.push_back(read_study(file, fmt::format("{}/{}", needles_group, name)));
    if (needles.needles.empty())
        file.refuse(needles_group, "is empty");
    return needles;
}

} // namespace

void write_needles(const std::filesystem::path &path, const NeedleFile &needles) {
    OutputFile file;
    hdf5::write_provenance(file, needles.provenance);
    file.text("/", "body", needles.body);
    file.text("/", "load_case", needles.load_case);
    file.text("/", "title", needles.title);
    file.group(needles_group, true);
    for (std::size_t n = 0; n < needles.needles.size(); ++n)
        write_study(file, fmt::format("{}/{}", needles_group, n), needles.needles[n]);
    support::write_whole(path, file.image());
}

NeedleFile read_needles_file(const std::filesystem::path &path) {
    return hdf5::read_once_tried(path, [&] { return needles_in(path); });
}

} // namespace livermark::results
