#include "results/history_file.hpp"

#include <fmt/format.h>

#include "core/whole_file.hpp"
#include "results/file_parts.hpp"

namespace livermark::results {

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
    core::write_whole(path, file.image());
}

} // namespace livermark::results
