#include "results/hdf5/files/stability_file.hpp"

#include "results/hdf5/file_parts.hpp"
#include "results/hdf5/io/read_apart.hpp"
#include "support/whole_file.hpp"

namespace livermark::results {

void write_stability(const std::filesystem::path &path, const Stability &stability) {
    hdf5::OutputFile file;
    hdf5::write_provenance(file, stability.provenance);
    file.text("/", "body", stability.body);
    file.text("/", "spring_law", stability.spring_law);
    file.text("/", "model", stability.model);
    file.text("/", "load_case", stability.load_case);
    file.number("/", "alpha", stability.damping.alpha);
    file.number("/", "beta", stability.damping.beta);
    file.number("/", "lowest_angular_frequency", stability.lowest_frequency);
    file.number("/", "largest_angular_frequency", stability.largest_frequency);
    file.number("/", "largest_angular_frequency_bound", stability.largest_frequency_bound);
    file.number("/", "element_time_step", stability.element_time_step);

    std::vector<std::string> names;
    for (const auto &limits : stability.limits)
        names.push_back(limits.integrator);
    file.group("/critical_time_step");
    file.texts("/critical_time_step", "integrators", names);
    const auto write_steps = [&](const std::string &name, auto step) {
        hdf5::write_column(file, "/critical_time_step/" + name, stability.limits, step, "s");
    };
    write_steps("undamped_predicted", [](const auto &limits) { return limits.undamped.predicted; });
    write_steps("undamped_observed", [](const auto &limits) { return limits.undamped.observed; });
    write_steps("damped_predicted", [](const auto &limits) { return limits.damped.predicted; });
    write_steps("damped_observed", [](const auto &limits) { return limits.damped.observed; });
    support::write_whole(path, file.image());
}

namespace {

Stability stability_in(const std::filesystem::path &path) {
    const hdf5::InputFile file(path, "livermark stability");
    hdf5::check_schema(file);
    Stability stability{.provenance = hdf5::read_provenance(file),
                        .body = file.text("/", "body"),
                        .spring_law = file.text("/", "spring_law"),
                        .model = file.has_attribute("/", "model") ? file.text("/", "model") : "",
                        .load_case = file.text("/", "load_case"),
                        .damping = {.alpha = file.number("/", "alpha"), .beta = file.number("/", "beta")},
                        .lowest_frequency = file.number("/", "lowest_angular_frequency"),
                        .largest_frequency = file.number("/", "largest_angular_frequency"),
                        .largest_frequency_bound = file.number("/", "largest_angular_frequency_bound"),
                        .element_time_step = file.number("/", "element_time_step"),
                        .limits = {}};
    const auto names = file.texts("/critical_time_step", "integrators");
    const auto steps = [&](const std::string &name) {
        return file.dataset<double>("/critical_time_step/" + name, names.size());
    };
    const auto undamped_predicted = steps("undamped_predicted");
    const auto undamped_observed = steps("undamped_observed");
    const auto damped_predicted = steps("damped_predicted");
    const auto damped_observed = steps("damped_observed");
    for (std::size_t i = 0; i < names.size(); ++i)
        stability.limits.push_back(
            {names[i], {undamped_predicted[i], undamped_observed[i]}, {damped_predicted[i], damped_observed[i]}});
    return stability;
}

} // namespace

Stability read_stability(const std::filesystem::path &path) {
    return hdf5::read_once_tried(path, [&] { return stability_in(path); });
}

} // namespace livermark::results
