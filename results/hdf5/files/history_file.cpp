#include "results/hdf5/files/history_file.hpp"

#include <array>

#include "results/hdf5/file_parts.hpp"

namespace livermark::results {

namespace {

/// Attributes of a case: those of one degree of freedom, then those of a body.
constexpr std::array parameter_names{"mass", "stiffness", "damping", "alpha", "beta"};

template <class At> void describe_step(At at, hdf5::Of<At, StepHistory> &history) {
    at.number("time_step", history.time_step);
    at.number("diverged_at", history.diverged_at);
    at.rows("time", history.time, "s");
    at.check(!history.time.empty(), "time", "is empty");
    at.rows("displacement", history.displacement, "m", history.time.size());
}

template <class At> void describe_parameter_list(At at, hdf5::Of<At, HistoryCase> &entry) {
    if constexpr (At::reads)
        for (const auto *const name : parameter_names)
            if (at.has(name))
                entry.parameters.emplace_back(name, 0.0);
    for (auto &[name, value] : entry.parameters)
        at.number(name, value);
}

template <class At> void describe_histories(At root, hdf5::Of<At, Histories> &histories) {
    root.text("subject", histories.subject);
    root.text("integrator", histories.integrator);
    root.group("histories", hdf5::Order::kept)
        .each(
            histories.cases, &HistoryCase::name,
            [](auto at, auto &entry) {
                at.text("title", entry.title);
                describe_parameter_list(at, entry);
                at.number("critical_time_step", entry.critical_time_step);
                at.each(entry.steps, [](auto place, auto &step) { describe_step(place, step); });
            },
            hdf5::Order::kept);
}

} // namespace

void write_histories(const std::filesystem::path &path, const Histories &histories) {
    hdf5::write_record(path, histories, [](auto root, auto &record) { describe_histories(root, record); });
}

Histories read_histories(const std::filesystem::path &path) {
    return hdf5::read_record<Histories>(path, "livermark histories",
                                        [](auto root, auto &record) { describe_histories(root, record); });
}

} // namespace livermark::results
