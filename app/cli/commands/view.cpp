#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <unistd.h>

#include "app/cli/commands/commands.hpp"
#include "app/server/serve.hpp"
#include "app/server/sessions/live_fem.hpp"
#include "app/server/sessions/live_springs.hpp"
#include "app/server/site.hpp"
#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/support/processes/child_process.hpp"
#include "results/hdf5/result_file.hpp"

namespace livermark::cli {

namespace {

namespace fs = std::filesystem;

/// Whether somebody sits in front of this: standard output is a terminal, and there is a screen.
bool has_screen() {
    const auto is_set = [](const char *name) {
        const char *value = std::getenv(name); // NOLINT(concurrency-mt-unsafe): nobody changes the environment
        return value && *value;
    };
    return isatty(fileno(stdout)) != 0 && (is_set("DISPLAY") || is_set("WAYLAND_DISPLAY"));
}

/// Shows an address in the browser of the desktop (`xdg-open`), which goes on when this program ends.
///
/// Every user of the machine may read the words that a program is started with, and the address has the token: what
/// `xdg-open` is given is a file for this user alone, which leads there.
class OpenedBrowser {
  public:
    /// @param address  http://...
    /// @throws support::InputError if no temporary file can be made
    explicit OpenedBrowser(const std::string &address) {
        const auto file = folder_.path / "open.html";
        std::ofstream(file) << fmt::format("<!doctype html><meta charset=\"utf-8\"><title>Livermark</title>\n"
                                           "<meta http-equiv=\"refresh\" content=\"0; url={0}\">\n"
                                           "<p><a href=\"{0}\">The page of livermark view</a></p>\n",
                                           address);
        // A session of its own: Ctrl-C in this terminal ends the server, and not the browser.
        constexpr auto *start = "command -v xdg-open >/dev/null || exit 1\n"
                                "setsid xdg-open \"$1\" </dev/null >/dev/null 2>&1 &";
        was_started_ = support::run_program({"sh", "-c", start, "sh", file.string()}).status == 0;
    }

    /// False where there is no `xdg-open`.
    bool was_started() const { return was_started_; }

  private:
    support::ScratchFolder folder_; ///< with the file; it goes with this object
    bool was_started_ = false;
};

struct ViewOptions {
    std::string folder;
    std::uint16_t port = 8421;
    std::optional<bool> opens_browser; ///< nothing said: where there is a screen
};

/// Without symlinks and dots, so that paths below it can be told.
fs::path existing_folder(const std::string &name) {
    std::error_code error;
    auto folder = fs::canonical(name, error);
    if (error)
        throw support::InputError(
            fmt::format("{}: there is no such folder; check the path, or make results with `livermark run`", name));
    if (!fs::is_directory(folder, error))
        throw support::InputError(fmt::format("{}: this is not a folder; give the one that the file is in", name));
    return folder;
}

fs::path built_page() {
    auto page = support::root_folder() / "app" / "viewer" / "dist" / "index.html";
    std::error_code error;
    if (!fs::is_regular_file(page, error))
        throw support::InputError(
            fmt::format("{}: the page is not there; make it with: cd {} && npm ci && npm run build", page.string(),
                        (support::root_folder() / "app" / "viewer").string()));
    return page;
}

int view(const ViewOptions &options) {
    const auto folder = existing_folder(options.folder);
    server::Site site{
        .folder = folder,
        .page = {},
        .port = options.port,
        .token = server::new_token(),
        .is_result_file = server::remembered(results::is_shown_on_page),
        .sessions = {
            {"/live/fem",
             [folder](const server::Fields &query, const server::ReportProgress &report) {
                 return server::live_fem(folder, query, report);
             }},
            {"/live/springs", [folder](const server::Fields &query,
                                       const server::ReportProgress &) { return server::live_springs(folder, query); }},
        }};
    const auto files = server::result_files(site);
    const auto num_files = files.paths.size();
    if (files.num_not_utf8 > 0)
        fmt::print(stderr,
                   "livermark: {}: the names of {} more result files are not UTF-8, and they are left out; "
                   "rename them\n",
                   support::shown(options.folder), files.num_not_utf8);
    if (files.num_in_use > 0 && num_files > 0)
        fmt::print(stderr,
                   "livermark: {}: another program has {} of the files open to write, and they are left out until it "
                   "closes them\n",
                   support::shown(options.folder), files.num_in_use);
    if (num_files == 0 && files.num_in_use > 0)
        throw support::InputError(fmt::format(
            "{}: another program has all result files here open to write; close them there", options.folder));
    if (num_files == 0)
        throw support::InputError(
            fmt::format("{}: there are no result files here; make some with `livermark run`", options.folder));
    site.page = built_page();
    std::optional<OpenedBrowser> browser;
    server::serve(site, [&](std::uint16_t port) {
        const auto address = fmt::format("http://127.0.0.1:{}/?token={}", port, site.token);
        fmt::print("{}: {} result file{}, to be seen at {} until Ctrl-C\n", options.folder, num_files,
                   num_files == 1 ? "" : "s", address);
        std::fflush(stdout);
        if (!options.opens_browser.value_or(has_screen()))
            return;
        browser.emplace(address);
        if (!browser->was_started())
            fmt::print(stderr, "livermark: there is no xdg-open to open a browser with (Debian package xdg-utils); "
                               "open the address yourself\n");
    });
    return 0;
}

} // namespace

Command add_view(CLI::App &parent) {
    auto *command = parent.add_subcommand("view", "Show result files in a browser on this machine");
    auto options = std::make_shared<ViewOptions>();
    options->folder = (support::root_folder() / "results" / "runs").string();
    command
        ->add_option("folder", options->folder,
                     "Folder with files of 'livermark run' or 'livermark experiment', at any depth")
        ->capture_default_str();
    command->add_option("--port", options->port, "Port on 127.0.0.1; 0 takes a free one")
        ->check(CLI::Range(0, 65535))
        ->capture_default_str();
    command->add_flag("--browser,!--no-browser", options->opens_browser,
                      "Open the page in a browser, or not; by default it opens if there is a screen");
    return [options] { return view(*options); };
}

} // namespace livermark::cli
