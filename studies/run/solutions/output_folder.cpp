#include "studies/run/solutions/output_folder.hpp"

#include <fmt/format.h>

#include "support/input_error.hpp"

namespace livermark::studies {

std::filesystem::path make_output_folder(const std::filesystem::path &output, const core::Problem &problem) {
    return make_output_folder(output, problem.body->name);
}

std::filesystem::path make_output_folder(const std::filesystem::path &output, const std::string &name) {
    auto folder = output / name;
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error)
        throw support::InputError(
            fmt::format("{}: cannot be made ({}); choose another --output", folder.string(), error.message()));
    return folder;
}

} // namespace livermark::studies
