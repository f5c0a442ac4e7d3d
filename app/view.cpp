#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <string>
#include <system_error>

#include "app/commands.hpp"
#include "app/live_fem.hpp"
#include "app/live_springs.hpp"
#include "core/input_error.hpp"
#include "core/root_folder.hpp"
#include "results/result_files.hpp"
#include "server/serve.hpp"

namespace livermark::app {

namespace {

namespace fs = std::filesystem;

struct ViewOptions {
    std::string folder;
    std::uint16_t port = 8421;
};

/// Without symlinks and dots, so that paths below it can be told.
fs::path existing_folder(const std::string &name) {
    std::error_code error;
    auto folder = fs::canonical(name, error);
    if (error)
        throw core::InputError(
            fmt::format("{}: there is no such folder; check the path, or make results with `livermark run`", name));
    if (!fs::is_directory(folder, error))
        throw core::InputError(fmt::format("{}: this is not a folder; give the one that the file is in", name));
    return folder;
}

fs::path built_page() {
    auto page = core::root_folder() / "viewer" / "dist" / "index.html";
    std::error_code error;
    if (!fs::is_regular_file(page, error))
        throw core::InputError(fmt::format("{}: the page is not there; make it with: cd {} && npm ci && npm run build",
                                           page.string(), (core::root_folder() / "viewer").string()));
    return page;
}

int view(const ViewOptions &options) {
    const auto folder = existing_folder(options.folder);
    server::Site site{
        .folder = folder,
        .page = {},
        .port = options.port,
        .is_result_file = results::is_result_file,
        .conversations = {
            {"/live/fem", [folder](const server::Fields &query) { return live_fem(folder, query); }},
            {"/live/springs", [folder](const server::Fields &query) { return live_springs(folder, query); }},
        }};
    const auto num_files = server::result_files(site).size();
    if (num_files == 0)
        throw core::InputError(
            fmt::format("{}: there are no result files here; make some with `livermark run`", options.folder));
    site.page = built_page();
    server::serve(site, [&](std::uint16_t port) {
        fmt::print("{}: {} result file{}, to be seen at http://127.0.0.1:{}/ until Ctrl-C\n", options.folder, num_files,
                   num_files == 1 ? "" : "s", port);
        std::fflush(stdout);
    });
    return 0;
}

} // namespace

Command add_view(CLI::App &parent) {
    auto *command = parent.add_subcommand("view", "Look at result files in a browser on this machine");
    auto options = std::make_shared<ViewOptions>();
    options->folder = (core::root_folder() / "results" / "runs").string();
    command->add_option("folder", options->folder, "Folder with result files of 'livermark run', at any depth")
        ->capture_default_str();
    command->add_option("--port", options->port, "Port on 127.0.0.1; 0 for any that is free")
        ->check(CLI::Range(0, 65535))
        ->capture_default_str();
    return [options] { return view(*options); };
}

} // namespace livermark::app
