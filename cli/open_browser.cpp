#include "cli/open_browser.hpp"

#include <cstdio>
#include <cstdlib>
#include <fmt/format.h>
#include <fstream>
#include <unistd.h>

namespace livermark::cli {

bool has_screen() {
    const auto is_set = [](const char *name) {
        const char *value = std::getenv(name); // NOLINT(concurrency-mt-unsafe): nobody changes the environment
        return value && *value;
    };
    return isatty(fileno(stdout)) != 0 && (is_set("DISPLAY") || is_set("WAYLAND_DISPLAY"));
}

OpenedBrowser::OpenedBrowser(const std::string &address) {
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

} // namespace livermark::cli
