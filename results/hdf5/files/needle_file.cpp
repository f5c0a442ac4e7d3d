#include "results/hdf5/files/needle_file.hpp"

#include "results/hdf5/file_parts.hpp"
#include "results/hdf5/files/needles/needle_arena_group.hpp"

namespace livermark::results {

namespace {

/// Datasets with a row for each record.
template <class At> void describe_insertion(At at, hdf5::Of<At, core::Insertion> &insertion) {
    at.rows("depth", insertion.depth, "m");
    const auto num_records = insertion.depth.size();
    at.rows("force", insertion.force, "N", num_records);
    at.rows("tip", insertion.tip, "m", num_records);
    at.rows("target", insertion.target, "m", num_records);
    at.rows("entry", insertion.entry, "m", num_records);
    at.rows("work", insertion.work, "J", num_records);
    at.rows("stored", insertion.stored, "J", num_records);
    at.rows("friction", insertion.friction, "J", num_records);
    at.rows("tearing", insertion.tearing, "J", num_records);
    if (at.has("holding")) // not in files of an older version
        at.rows("holding", insertion.holding, "J", num_records);
    at.integer("at_plan", insertion.at_plan, 0, insertion.num_records() - 1);
    at.number("puncture_depth", insertion.puncture_depth);
    at.number("puncture_loss", insertion.puncture_loss);
    if (at.has("stopped_at")) // nor this
        at.number("stopped_at", insertion.stopped_at);
}

template <class At> void describe_needle(At at, hdf5::Of<At, NeedleStudy> &study) {
    auto &needle = study.needle;
    at.text("name", needle.name);
    at.rows_of("way", "m", needle.entry, needle.target);
    at.number("diameter", needle.diameter);
    at.number("spread", needle.spread);
    at.number("toughness", needle.toughness);
    at.number("friction", needle.friction);
    at.number("puncture_force", needle.puncture_force);
    at.number("step", needle.step);
    std::string reference = study.runs.empty() ? "" : study.runs.front().model;
    at.text("reference", reference);
    at.number("reference_miss_change", study.reference_miss_change);
    at.number("reference_force_change", study.reference_force_change);
    at.group("models", hdf5::Order::kept).each(study.runs, &NeedleRun::model, [](auto of_model, auto &run) {
        describe_insertion(of_model, run.insertion);
        of_model.number("setup_seconds", run.setup_seconds);
        if (of_model.has("solve_seconds")) // not in files of an older version
            of_model.number("solve_seconds", run.solve_seconds);
        if (of_model.has("left_regime_at")) // nor this
            of_model.number("left_regime_at", run.left_regime_at);
    });
    at.check(!study.runs.empty() && study.runs.front().model == reference, "does not begin with its reference");
    for (const auto &run : study.runs)
        at.check(run.insertion.at_plan == study.runs.front().insertion.at_plan, "has models with different steps");
    at.optional("arena", study.arena, [&](auto &arena) { describe_needle_arena(at.group("arena"), arena); });
}

template <class At> void describe_needles(At root, hdf5::Of<At, NeedleFile> &file) {
    root.text("body", file.body);
    root.text("load_case", file.load_case);
    root.text("title", file.title);
    if (root.has("regime")) // not in files of an older version
        root.word("regime", file.regime);
    root.group("needles", hdf5::Order::kept)
        .each(
            file.needles, [](auto at, auto &study) { describe_needle(at, study); }, hdf5::Order::kept);
    root.check(!file.needles.empty(), "needles", "is empty");
}

} // namespace

void write_needles(const std::filesystem::path &path, const NeedleFile &needles) {
    hdf5::write_record(path, needles, [](auto root, auto &record) { describe_needles(root, record); });
}

NeedleFile read_needles_file(const std::filesystem::path &path) {
    return hdf5::read_record<NeedleFile>(path, "livermark needle",
                                         [](auto root, auto &record) { describe_needles(root, record); });
}

} // namespace livermark::results
