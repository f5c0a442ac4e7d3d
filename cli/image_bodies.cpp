#include "cli/image_bodies.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>

#include "cli/segment.hpp"
#include "studies/catalogue.hpp"
#include "studies/run/output_folder.hpp"
#include "support/input_error.hpp"
#include "support/mpi_session.hpp"
#include "support/root_folder.hpp"
#include "support/toml_input.hpp"

namespace livermark::cli {

namespace {

namespace fs = std::filesystem;

/// @return the name without the ending of a label image, or nothing if it is no such name
std::string stem_of_image(const std::string &body) {
    const fs::path path = body;
    std::error_code error;
    if (fs::is_directory(path, error) && path.extension() != ".toml")
        return (path.has_filename() ? path : path.parent_path()).filename().string();
    const auto name = path.filename().string();
    for (const std::string_view ending : {".nii.gz", ".nii", ".nrrd", ".nhdr", ".mha", ".mhd"})
        if (name.size() > ending.size() && name.ends_with(ending))
            return name.substr(0, name.size() - ending.size());
    return {};
}

} // namespace

std::vector<std::string> with_images_meshed(std::vector<std::string> bodies, const std::string &output,
                                            const std::string &command_line) {
    const auto shipped = support::list_toml(support::root_folder() / studies::bodies_folder);
    for (auto &body : bodies) {
        const auto stem = stem_of_image(body);
        // Where results are kept there are folders with the names of bodies.
        if (stem.empty() || std::ranges::find(shipped, body) != shipped.end())
            continue;
        if (support::started_on_many_ranks())
            throw support::InputError(
                fmt::format("{}: an image is meshed by one process; do it first, with `livermark mesh "
                            "--labels`, and give the body file",
                            body));
        const auto folder = studies::make_output_folder(output, "");
        const auto body_file = folder / (stem + ".toml");
        if (fs::exists(body_file))
            fmt::print(stderr, "livermark: {} is taken for {}; remove it to mesh the image anew\n", body_file.string(),
                       body);
        else
            try {
                make_body_of_labels({.labels = body,
                                     .output = (folder / (stem + ".msh")).string(),
                                     .command_line = command_line,
                                     .table = stderr});
            } catch (const support::InputError &) {
                std::error_code error;
                fs::remove(folder, error); // unless something is in it
                throw;
            }
        body = body_file.string();
    }
    return bodies;
}

} // namespace livermark::cli
