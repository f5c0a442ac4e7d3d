#include "server/site.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <string_view>
#include <system_error>
#include <utility>

#include "core/input_error.hpp"

namespace livermark::server {

namespace {

namespace fs = std::filesystem;

Answer refusal(int status, const std::string &sentence) {
    return {.status = status, .content_type = "text/plain; charset=utf-8", .text = sentence + "\n", .file = {}};
}

Answer not_there() {
    return refusal(404, "There is no such result file here.");
}

bool is_own_host(std::string_view host, std::uint16_t port) {
    return host == fmt::format("127.0.0.1:{}", port) || host == fmt::format("localhost:{}", port);
}

Answer of_strangers() {
    return refusal(403, "Only pages of this server may ask it.");
}

Answer not_well_formed() {
    return refusal(400, "The address is not well formed.");
}

bool is_own_origin(std::string_view origin, std::uint16_t port) {
    constexpr std::string_view scheme = "http://";
    return origin.starts_with(scheme) && is_own_host(origin.substr(scheme.size()), port);
}

/// Names of folders and a file, and nothing that leads elsewhere.
bool is_plain_path(const std::string &path) {
    if (path.empty() || path.front() == '/' || path.find('\0') != std::string::npos)
        return false;
    return std::ranges::none_of(fs::path(path), [](const fs::path &name) { return name == ".." || name == "."; });
}

bool is_below(const fs::path &file, const fs::path &folder) {
    const auto [end, ignored] = std::ranges::mismatch(folder, file);
    return end == folder.end();
}

/// The file itself, if it is a result file of the folder.
std::optional<fs::path> file_of(const fs::path &path, const fs::path &folder) {
    std::error_code error;
    auto file = fs::canonical(folder / path, error);
    // What a link leads to has to be what its name says: no other file of the folder goes out under a name in .h5.
    if (error || !is_below(file, folder) || file.extension() != ".h5" || path.extension() != ".h5")
        return std::nullopt;
    if (!fs::is_regular_file(file, error))
        return std::nullopt;
    return file;
}

std::string json_text(std::string_view text) {
    std::string quoted = "\"";
    for (const char c : text)
        if (c == '"' || c == '\\')
            (quoted += '\\') += c;
        else if (static_cast<unsigned char>(c) < 0x20)
            quoted += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
        else
            quoted += c;
    return quoted + '"';
}

Answer list(const Site &site) {
    std::vector<std::string> entries;
    for (const auto &path : result_files(site)) {
        std::error_code error;
        const auto bytes = fs::file_size(site.folder / path, error);
        entries.push_back(fmt::format("{{\"path\":{},\"bytes\":{}}}", json_text(path), error ? 0 : bytes));
    }
    return {.status = 200,
            .content_type = "application/json",
            .text = fmt::format("[{}]", fmt::join(entries, ",")),
            .file = {}};
}

} // namespace

Answer answer(const Request &request, const Site &site) {
    if (!is_own_host(request.host, site.port) || (request.origin && !is_own_origin(*request.origin, site.port)))
        return of_strangers();
    if (request.method != "GET" && request.method != "HEAD")
        return refusal(405, "This server only shows files.");
    const auto path = percent_decoded(request.target.substr(0, request.target.find('?')));
    if (!path)
        return not_well_formed();
    if (*path == "/" || *path == "/index.html")
        return {.status = 200, .content_type = "text/html; charset=utf-8", .text = {}, .file = site.page};
    if (*path == "/files.json")
        return list(site);
    constexpr std::string_view files = "/files/";
    if (!path->starts_with(files))
        return not_there();
    auto file = shown_file(path->substr(files.size()), site.folder);
    if (!file)
        return not_there();
    return {.status = 200, .content_type = "application/x-hdf5", .text = {}, .file = std::move(*file)};
}

std::variant<Opening, Answer> opening(const Request &request, const Site &site) {
    if (!is_own_host(request.host, site.port) || !request.origin || !is_own_origin(*request.origin, site.port))
        return of_strangers();
    const auto end = std::min(request.target.find('?'), request.target.size());
    const auto path = percent_decoded(std::string_view(request.target).substr(0, end));
    if (!path)
        return not_well_formed();
    const auto found = site.conversations.find(*path);
    if (found == site.conversations.end())
        return refusal(404, "There is no such conversation here.");
    try {
        return Opening{found->second, parse_fields(request.target.substr(std::min(end + 1, request.target.size())))};
    } catch (const core::InputError &) {
        return not_well_formed();
    }
}

std::optional<fs::path> shown_file(const std::string &path, const fs::path &folder) {
    return is_plain_path(path) ? file_of(path, folder) : std::nullopt;
}

std::vector<std::string> result_files(const Site &site) {
    std::error_code error;
    std::vector<std::string> found;
    for (auto entry =
             fs::recursive_directory_iterator(site.folder, fs::directory_options::skip_permission_denied, error);
         !error && entry != fs::recursive_directory_iterator(); entry.increment(error)) {
        const auto path = entry->path().lexically_relative(site.folder);
        if (const auto file = file_of(path, site.folder); file && site.is_result_file(*file))
            found.push_back(path.generic_string());
    }
    if (error)
        throw core::InputError(
            fmt::format("{}: cannot be listed ({}); see who may read it", site.folder.string(), error.message()));
    std::ranges::sort(found);
    return found;
}

} // namespace livermark::server
