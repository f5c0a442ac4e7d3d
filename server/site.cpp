#include "server/site.hpp"

#include <algorithm>
#include <charconv>
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

bool is_own_origin(std::string_view origin, std::uint16_t port) {
    constexpr std::string_view scheme = "http://";
    return origin.starts_with(scheme) && is_own_host(origin.substr(scheme.size()), port);
}

/// @return nothing if a % is not followed by two hexadecimal digits
std::optional<std::string> percent_decoded(std::string_view text) {
    std::string decoded;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] != '%') {
            decoded += text[i];
            continue;
        }
        unsigned value = 0;
        const auto *digits = text.data() + i + 1;
        if (i + 2 >= text.size() || std::from_chars(digits, digits + 2, value, 16).ptr != digits + 2)
            return std::nullopt;
        decoded += static_cast<char>(value);
        i += 2;
    }
    return decoded;
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
std::optional<fs::path> file_of(const fs::path &path, const Site &site) {
    std::error_code error;
    auto file = fs::canonical(site.folder / path, error);
    // What a link leads to has to be what its name says: no other file of the folder goes out under a name in .h5.
    if (error || !is_below(file, site.folder) || file.extension() != ".h5" || path.extension() != ".h5")
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
        return refusal(403, "Only pages of this server may ask it.");
    if (request.method != "GET" && request.method != "HEAD")
        return refusal(405, "This server only shows files.");
    const auto path = percent_decoded(request.target.substr(0, request.target.find('?')));
    if (!path)
        return refusal(400, "The address is not well formed.");
    if (*path == "/" || *path == "/index.html")
        return {.status = 200, .content_type = "text/html; charset=utf-8", .text = {}, .file = site.page};
    if (*path == "/files.json")
        return list(site);
    constexpr std::string_view files = "/files/";
    if (!path->starts_with(files))
        return not_there();
    const auto name = path->substr(files.size());
    auto file = is_plain_path(name) ? file_of(name, site) : std::nullopt;
    if (!file)
        return not_there();
    return {.status = 200, .content_type = "application/x-hdf5", .text = {}, .file = std::move(*file)};
}

std::vector<std::string> result_files(const Site &site) {
    std::error_code error;
    std::vector<std::string> found;
    for (auto entry =
             fs::recursive_directory_iterator(site.folder, fs::directory_options::skip_permission_denied, error);
         !error && entry != fs::recursive_directory_iterator(); entry.increment(error)) {
        const auto path = entry->path().lexically_relative(site.folder);
        if (const auto file = file_of(path, site); file && site.is_result_file(*file))
            found.push_back(path.generic_string());
    }
    if (error)
        throw core::InputError(
            fmt::format("{}: cannot be listed ({}); see who may read it", site.folder.string(), error.message()));
    std::ranges::sort(found);
    return found;
}

} // namespace livermark::server
