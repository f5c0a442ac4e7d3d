#include "results/hdf5/cut_file.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "results/hdf5/file_parts.hpp"
#include "results/hdf5/io/hdf5_io.hpp"
#include "results/hdf5/io/read_apart.hpp"
#include "support/whole_file.hpp"

namespace livermark::results {

namespace {

constexpr const char *cut_group = "/cut";

/// Calls for each row of records of a model with its name and its units.
template <class Run, class Visit> void for_each_row(Run &run, Visit visit) {
    visit("stored", run.stored, "J");
    visit("work", run.work, "J");
    visit("opening", run.opening, "m");
    visit("tool_stiffness", run.tool_stiffness, "N/m");
    visit("setup_seconds", run.setup_seconds, "s");
    visit("solve_seconds", run.solve_seconds, "s");
}

CutFile cut_in(const std::filesystem::path &path) {
    const hdf5::InputFile file(path, "livermark cut");
    hdf5::check_schema(file);
    CutFile cut{.provenance = hdf5::read_provenance(file),
                .body = file.text("/", "body"),
                .load_case = file.text("/", "load_case"),
                .title = file.text("/", "title")};
    const std::string group = cut_group;
    std::ranges::copy(file.dataset<core::Vector3>(group + "/blade", 4), cut.blade.begin());
    cut.toughness = file.number(group, "toughness");
    cut.depth = file.dataset<double>(group + "/depth");
    const auto size = cut.depth.size();
    if (size == 0)
        file.refuse(group + "/depth", "is empty");
    cut.area = file.dataset<double>(group + "/area", size);
    cut.cut_seconds = file.dataset<double>(group + "/cut_seconds", size);
    cut.nodes = file.dataset<int>(group + "/nodes", size);
    for (const auto &model : file.children(group + "/models")) {
        CutRun run{.model = model};
        for_each_row(run, [&](const char *name, auto &values, const char *) {
            values = file.dataset<double>(fmt::format("{}/models/{}/{}", group, model, name), size);
        });
        cut.runs.push_back(std::move(run));
    }
    if (cut.runs.empty() || cut.runs.front().model != file.text(group, "reference"))
        file.refuse(group, "does not begin with its reference");
    return cut;
}

} // namespace

void write_cut(const std::filesystem::path &path, const CutFile &cut) {
    hdf5::OutputFile file;
    hdf5::write_provenance(file, cut.provenance);
    file.text("/", "body", cut.body);
    file.text("/", "load_case", cut.load_case);
    file.text("/", "title", cut.title);
    const std::string group = cut_group;
    file.group(group, true);
    file.number(group, "toughness", cut.toughness);
    file.text(group, "reference", cut.runs.front().model);
    file.dataset(group + "/blade", std::vector<core::Vector3>(cut.blade.begin(), cut.blade.end()), "m");
    file.dataset(group + "/depth", cut.depth, "m");
    file.dataset(group + "/area", cut.area, "m^2");
    file.dataset(group + "/cut_seconds", cut.cut_seconds, "s");
    file.dataset(group + "/nodes", cut.nodes, "");
    file.group(group + "/models", true);
    for (const auto &run : cut.runs) {
        const auto of_model = fmt::format("{}/models/{}", group, run.model);
        file.group(of_model);
        for_each_row(run, [&](const char *name, const auto &values, const char *units) {
            file.dataset(fmt::format("{}/{}", of_model, name), values, units);
        });
    }
    support::write_whole(path, file.image());
}

CutFile read_cut_file(const std::filesystem::path &path) {
    return hdf5::read_once_tried(path, [&] { return cut_in(path); });
}

} // namespace livermark::results
