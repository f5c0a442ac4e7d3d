#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>

#include "experiments/experiment.hpp"
#include "support/input_error.hpp"
#include "support/root_folder.hpp"

namespace livermark::experiments {

std::filesystem::path data_folder() {
    const char *folder = std::getenv("LIVERMARK_EXPERIMENTS"); // NOLINT(concurrency-mt-unsafe): nobody changes it
    return folder ? std::filesystem::path(folder)
                  : (support::root_folder() / ".." / "shared" / "experiments").lexically_normal();
}

bool has_data(const PublicExperiment &experiment) {
    std::error_code ignored;
    return std::filesystem::exists(data_folder() / experiment.data, ignored);
}

Experiment read_public(const PublicExperiment &experiment) {
    const auto data = data_folder() / experiment.data;
    if (!has_data(experiment))
        throw support::InputError(fmt::format("{}: the data of experiment {} are not there; get them from {}, and put "
                                              "them there or say in LIVERMARK_EXPERIMENTS which folder {} is in",
                                              data.string(), experiment.name, experiment.source, experiment.data));
    auto result = experiment.read(data);
    result.name = experiment.name;
    result.title = experiment.title;
    result.source = experiment.source;
    check(result, data.string());
    return result;
}

} // namespace livermark::experiments
