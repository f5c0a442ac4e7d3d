#include "app/cli/image_bodies.hpp"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fmt/format.h>

#include "app/cli/segment.hpp"
#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/support/processes/mpi_session.hpp"
#include "core/support/toml_input.hpp"
#include "meshes/io/mesh_files.hpp"
#include "studies/files.hpp"

namespace livermark::cli {

namespace {

namespace fs = std::filesystem;

/// Whether a body file is that of these sources.
bool is_made_of(const BodySources &sources, const fs::path &body_file) {
    try {
        const auto known = sources_in(body_file);
        return known && known->is_same_body(sources);
    } catch (const support::InputError &) {
        return false; // damaged, so nothing to take
    }
}

/// The body file of these sources: the one that is there, or a name that no other body has.
fs::path place_of(const fs::path &folder, const std::string &stem, const BodySources &sources) {
    auto plain = folder / (stem + ".toml");
    std::error_code error;
    if (!fs::exists(plain, error) || is_made_of(sources, plain))
        return plain;
    support::FnvHash hash;
    hash.add(sources.options);
    hash.add(sources.content);
    return folder / fmt::format("{}_{:08x}.toml", stem, static_cast<std::uint32_t>(hash.value() >> 32));
}

/// Body files that are made in the output folder.
class Mesher {
  public:
    Mesher(const std::string &output, const std::string &command_line, bool force)
        : output_(output), command_line_(command_line), force_(force) {}

    /// @param source  for messages
    /// @param make    writes a body
    /// @return the body file
    std::string body_of(const std::string &source, const std::string &stem, const char *option, SegmentCommand command,
                        int (*make)(const SegmentCommand &)) const {
        if (support::started_on_many_ranks())
            throw support::InputError(fmt::format("{}: only one process can mesh a segmentation; mesh it first with "
                                                  "`livermark mesh {}`, and give the body file",
                                                  source, option));
        const studies::OutputFolder output(output_);
        const auto &folder = output.path();
        const auto sources = sources_of(command);
        const auto body_file = place_of(folder, stem, sources);
        const bool has_mesh = fs::exists(fs::path(body_file).replace_extension(".msh"));
        if (has_mesh && is_made_of(sources, body_file) && !force_) {
            fmt::print(stderr, "livermark: {} is used for {}; --force meshes it again\n", body_file.string(), source);
            return body_file.string();
        }
        if (body_file.stem() != stem)
            fmt::print(stderr,
                       "livermark: {} has other content than {}, so this body is called {}; results of both stay\n",
                       (folder / (stem + ".toml")).string(), source, body_file.stem().string());
        command.output = fs::path(body_file).replace_extension(".msh").string();
        command.command_line = command_line_;
        command.force = true;
        command.table = stderr;
        make(command);
        return body_file.string();
    }

  private:
    const std::string &output_, &command_line_;
    bool force_;
};

} // namespace

std::string stem_of_image(const std::string &body) {
    const fs::path path = body;
    std::error_code error;
    if (fs::is_directory(path, error) && path.extension() != ".toml")
        return (path.has_filename() ? path : path.parent_path()).filename().string();
    const auto name = path.filename().string();
    const auto lower = support::lower_case(name);
    for (const std::string_view ending :
         {".nii.gz", ".hdr.gz", ".img.gz", ".nii", ".hdr", ".img", ".nrrd", ".nhdr", ".mha", ".mhd", ".dcm"})
        if (name.size() > ending.size() && lower.ends_with(ending))
            return name.substr(0, name.size() - ending.size());
    return {};
}

std::vector<std::string> with_images_meshed(const std::vector<std::string> &bodies, const std::string &output,
                                            const std::string &command_line, bool force) {
    const auto shipped = support::list_toml(support::root_folder() / studies::bodies_folder);
    const Mesher mesher(output, command_line, force);
    std::vector<std::string> surfaces, with_bodies;
    for (const auto &body : bodies) {
        // Where results are kept there are folders with the names of bodies.
        const bool is_shipped = std::ranges::find(shipped, body) != shipped.end();
        if (const auto stem = stem_of_image(body); !stem.empty() && !is_shipped) {
            with_bodies.push_back(
                mesher.body_of(body, stem, "--labels", SegmentCommand{.labels = body}, make_body_of_labels));
        } else if (!is_shipped && meshes::is_surface_file(body)) {
            if (surfaces.empty())
                with_bodies.push_back(body); // for the liver; its lesions follow
            surfaces.push_back(body);
        } else {
            with_bodies.push_back(body);
        }
    }
    if (!surfaces.empty()) {
        const auto stem = fs::path(surfaces.front()).stem().string();
        *std::ranges::find(with_bodies, surfaces.front()) = mesher.body_of(
            surfaces.front(), stem, "--surfaces", SegmentCommand{.surfaces = surfaces}, make_body_of_surfaces);
    }
    return with_bodies;
}

std::vector<std::string> with_images_meshed(const std::vector<std::string> &bodies, const std::string &command_line) {
    return with_images_meshed(bodies, (support::root_folder() / "results" / "runs").string(), command_line, false);
}

std::string with_image_meshed(const std::string &body, const std::string &command_line) {
    return with_images_meshed({body}, command_line).front();
}

} // namespace livermark::cli
