#include "results/hdf5/files/history_file.hpp"

#include <array>
#include <fmt/format.h>

#include "results/hdf5/file_parts.hpp"
#include "results/hdf5/io/read_apart.hpp"
#include "support/whole_file.hpp"

namespace livermark::results {

namespace {

/// Attributes of a case: those of one degree of freedom, then those of a body.
constexpr std::array parameter_names{"mass", "stiffness", "damping", "alpha", "beta"};

StepHistory read_step(const hdf5::InputFile &file, const std::string &place) {
    StepHistory history{.time_step = file.number(place, "time_step"),
                        .time = file.dataset<double>(place + "/time"),
                        .displacement = {},
                        .diverged_at = file.number(place, "diverged_at")};
    if (history.time.empty())
        file.refuse(place + "/time", "is empty");
    history.displacement = file.dataset<double>(place + "/displacement", history.time.size());
    return history;
}

HistoryCase read_case(const hdf5::InputFile &file, const std::string &name) {
    const auto group = "/histories/" + name;
    HistoryCase entry{.name = name,
                      .title = file.text(group, "title"),
                      .parameters = {},
                      .critical_time_step = file.number(group, "critical_time_step"),
                      .steps = {}};
    for (const auto *const parameter : parameter_names)
        if (file.has_attribute(group, parameter))
            entry.parameters.emplace_back(parameter, file.number(group, parameter));
    for (const auto &step : file.children(group))
        entry.steps.push_back(read_step(file, fmt::format("{}/{}", group, step)));
    return entry;
}

} // namespace

void write_histories(const std::filesystem::path &path, const Histories &histories) {
    hdf5::OutputFile file;
    hdf5::write_provenance(file, histories.provenance);
    file.text("/", "subject", histories.subject);
    file.text("/", "integrator", histories.integrator);
    file.group("/histories", true);
    for (const auto &entry : histories.cases) {
        const auto group = "/histories/" + entry.name;
        file.group(group, true);
        file.text(group, "title", entry.title);
        for (const auto &[name, value] : entry.parameters)
            file.number(group, name, value);
        file.number(group, "critical_time_step", entry.critical_time_step);
        for (std::size_t s = 0; s < entry.steps.size(); ++s) {
            const auto &history = entry.steps[s];
            const auto place = fmt::format("{}/{}", group, s);
            file.group(place);
            file.number(place, "time_step", history.time_step);
            file.number(place, "diverged_at", history.diverged_at);
            file.dataset(place + "/time", history.time, "s");
            file.dataset(place + "/displacement", history.displacement, "m");
        }
    }
    support::write_whole(path, file.image());
}

namespace {

Histories histories_in(const std::filesystem::path &path) {
    const hdf5::InputFile file(path, "livermark histories");
    hdf5::check_schema(file);
    Histories histories{.provenance = hdf5::read_provenance(file),
                        .subject = file.text("/", "subject"),
                        .integrator = file.text("/", "integrator"),
                        .cases = {}};
    for (const auto &name : file.children("/histories"))
        histories.cases.push_back(read_case(file, name));
    return histories;
}

} // namespace

Histories read_histories(const std::filesystem::path &path) {
    return hdf5::read_once_tried(path, [&] { return histories_in(path); });
}

} // namespace livermark::results
