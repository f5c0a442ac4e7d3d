#include "results/hdf5/cut_file.hpp"

#include "results/hdf5/file_parts.hpp"
#include "results/hdf5/io/columns.hpp"

namespace livermark::results {

namespace {

/// @param num_records  K
template <class At> void describe_cut_run(At at, hdf5::Of<At, CutRun> &run, std::size_t num_records) {
    at.rows("stored", run.stored, "J", num_records);
    at.rows("work", run.work, "J", num_records);
    at.rows("opening", run.opening, "m", num_records);
    at.rows("tool_stiffness", run.tool_stiffness, "N/m", num_records);
    at.rows("setup_seconds", run.setup_seconds, "s", num_records);
    at.rows("solve_seconds", run.solve_seconds, "s", num_records);
    if (at.has("critical_time_step",
               !run.critical_time_step.empty())) // of springs, and not in files of an older version
        at.rows("critical_time_step", run.critical_time_step, "s");
}

template <class At> void describe_cut_motions(At at, hdf5::Of<At, CutFile> &cut) {
    at.number("frame_interval", cut.frame_interval);
    at.integer("frames_per_step", cut.frames_per_step, 1);
    auto columns = hdf5::columns_of(at, cut.motions);
    columns.texts("methods", &CutMotion::method);
    columns.texts("settings", &CutMotion::setting);
    columns.column("budget", &CutMotion::budget, "s");
    columns.column("steps", &CutMotion::steps);
    columns.column("iterations", &CutMotion::iterations);
    columns.column("setup_seconds", &CutMotion::setup_seconds, "s");
    columns.column("frame_seconds", &CutMotion::frame_seconds, "s");
    columns.column("worst_frame_seconds", &CutMotion::worst_frame_seconds, "s");
    columns.blocks("opening", &CutMotion::opening, cut.depth.size(), "m");
    columns.blocks("tool_stiffness", &CutMotion::tool_stiffness, cut.depth.size(), "N/m");
    columns.blocks("ready_seconds", &CutMotion::ready_seconds, cut.depth.size(), "s");
}

template <class At> void describe_finer_cuts(At at, hdf5::Of<At, CutFile> &cut) {
    auto columns = hdf5::columns_of(at, cut.levels);
    columns.texts("ways", &CutLevel::way);
    columns.column("tetrahedra", &CutLevel::tetrahedra);
    columns.column("area", &CutLevel::area, "m^2");
    columns.column("depth", &CutLevel::depth, "m");
    columns.column("opening", &CutLevel::opening, "m");
    columns.column("tool_stiffness", &CutLevel::tool_stiffness, "N/m");
    columns.column("solve_seconds", &CutLevel::solve_seconds, "s");
}

template <class At> void describe_cut(At root, hdf5::Of<At, CutFile> &cut) {
    root.text("body", cut.body);
    root.text("load_case", cut.load_case);
    root.text("title", cut.title);
    const auto at = root.group("cut", hdf5::Order::kept);
    at.number("toughness", cut.toughness);
    std::string reference = cut.runs.empty() ? "" : cut.runs.front().model;
    at.text("reference", reference);
    if (at.has("regime")) // not in files of an older version
        at.word("regime", cut.regime);
    at.rows("blade", cut.blade, "m");
    at.rows("depth", cut.depth, "m");
    at.check(!cut.depth.empty(), "depth", "is empty");
    const auto num_records = cut.depth.size();
    at.rows("area", cut.area, "m^2", num_records);
    at.rows("cut_seconds", cut.cut_seconds, "s", num_records);
    at.rows("nodes", cut.nodes, "", num_records);
    at.group("models", hdf5::Order::kept).each(cut.runs, &CutRun::model, [&](auto of_model, auto &run) {
        describe_cut_run(of_model, run, num_records);
    });
    at.check(!cut.runs.empty() && cut.runs.front().model == reference, "does not begin with its reference");
    if (at.has("finer", !cut.levels.empty())) // only where the reference was refined
        describe_finer_cuts(at.group("finer"), cut);
    if (at.has("motions", !cut.motions.empty())) // only where methods have moved
        describe_cut_motions(at.group("motions"), cut);
}

} // namespace

void write_cut(const std::filesystem::path &path, const CutFile &cut) {
    hdf5::write_record(path, cut, [](auto root, auto &record) { describe_cut(root, record); });
}

CutFile read_cut_file(const std::filesystem::path &path) {
    return hdf5::read_record<CutFile>(path, "livermark cut",
                                      [](auto root, auto &record) { describe_cut(root, record); });
}

} // namespace livermark::results
