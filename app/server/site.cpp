#include "app/server/site.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <random>
#include <string>
#include <string_view>
#include <sys/stat.h>
#include <system_error>
#include <tuple>
#include <utility>

#include "core/support/input_error.hpp"

namespace livermark::server {

namespace {

std::string cookie_name(std::uint16_t port) {
    return fmt::format("livermark_{}", port);
}

namespace fs = std::filesystem;

Response refusal(int status, const std::string &sentence) {
    return {.status = status, .content_type = "text/plain; charset=utf-8", .text = sentence + "\n", .file = {}};
}

Response not_there() {
    return refusal(404, "There is no such result file here.");
}

bool is_own_host(std::string_view host, std::uint16_t port) {
    constexpr std::uint16_t port_of_http = 80; // which browsers leave out
    if (port == port_of_http && (host == "127.0.0.1" || host == "localhost"))
        return true;
    return host == fmt::format("127.0.0.1:{}", port) || host == fmt::format("localhost:{}", port);
}

Response strangers_refused() {
    return refusal(403, "Only pages of this server may ask it.");
}

Response not_well_formed() {
    return refusal(400, "The address is not well formed.");
}

bool is_own_origin(std::string_view origin, std::uint16_t port) {
    constexpr std::string_view scheme = "http://";
    return origin.starts_with(scheme) && is_own_host(origin.substr(scheme.size()), port);
}

bool is_page(std::string_view path) {
    return path == "/" || path == "/index.html";
}

/// @return empty if there is none
std::string_view query_of(std::string_view target) {
    const auto end = target.find('?');
    return end == std::string_view::npos ? std::string_view() : target.substr(end + 1);
}

bool address_has_token(const Request &request, const Site &site) {
    try {
        const auto fields = parse_fields(query_of(request.target));
        const auto found = fields.find("token");
        return found != fields.end() && is_same(found->second, site.token);
    } catch (const support::InputError &) {
        return false;
    }
}

/// @return nothing for somebody who may ask
std::optional<Response> refused(const Request &request, const Site &site, bool needs_origin) {
    if (!is_own_host(request.host, site.port) ||
        (request.origin ? !is_own_origin(*request.origin, site.port) : needs_origin))
        return strangers_refused();
    const bool is_in_address = address_has_token(request, site);
    const bool is_visit = is_in_address && is_page(request.target.substr(0, request.target.find('?')));
    if (request.fetch_site && *request.fetch_site != "same-origin" && *request.fetch_site != "none" && !is_visit)
        return strangers_refused();
    if (site.token.empty() || !(is_in_address || cookie_has_token(request.cookies, site.port, site.token)))
        return refusal(403, "The token is missing or an old one: open the address that `livermark view` printed where "
                            "it was started.");
    return std::nullopt;
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
    // The target of a link has to be what its name says: no other file of the folder goes out under a name in .h5.
    if (error || !is_below(file, folder) || file.extension() != ".h5" || path.extension() != ".h5")
        return std::nullopt;
    if (!fs::is_regular_file(file, error))
        return std::nullopt;
    return file;
}

/// Well-formed UTF-8 (RFC 3629): no other bytes stand in JSON, or in the address that a page makes of it.
bool is_utf8(std::string_view text) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
    for (std::size_t i = 0; i < text.size();) {
        const unsigned lead = byte(i);
        const std::size_t length = lead < 0x80U ? 1 : lead < 0xe0U ? 2 : lead < 0xf0U ? 3 : 4;
        if ((lead >= 0x80U && lead < 0xc2U) || lead > 0xf4U || i + length > text.size())
            return false;
        for (std::size_t k = 1; k < length; ++k)
            if ((byte(i + k) & 0xc0U) != 0x80U)
                return false;
        // Longer than need be, half of a pair, or beyond the last character.
        if (length > 2) {
            const unsigned second = byte(i + 1);
            if ((lead == 0xe0U && second < 0xa0U) || (lead == 0xedU && second > 0x9fU) ||
                (lead == 0xf0U && second < 0x90U) || (lead == 0xf4U && second > 0x8fU))
                return false;
        }
        i += length;
    }
    return true;
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

Response list(const Site &site) {
    std::vector<std::string> entries;
    for (const auto &path : result_files(site).paths) {
        std::error_code error;
        const auto bytes = fs::file_size(site.folder / path, error);
        entries.push_back(fmt::format("{{\"path\":{},\"bytes\":{}}}", json_text(path), error ? 0 : bytes));
    }
    return {.status = 200,
            .content_type = "application/json",
            .text = fmt::format("[{}]", fmt::join(entries, ",")),
            .file = {}};
}

Response image_for(const fs::path &file, const Site &site) {
    try {
        return {.status = 200, .content_type = "application/json", .text = site.image_of(file), .file = {}};
    } catch (const support::InputError &why_not) {
        return refusal(404, why_not.what());
    }
}

using State = std::tuple<dev_t, ino_t, off_t, time_t, long>; ///< device, inode, size, time of change [s], [ns]

std::optional<State> state_of(const std::filesystem::path &path) {
    struct stat found {};
    if (::stat(path.c_str(), &found) != 0)
        return std::nullopt;
    return State{found.st_dev, found.st_ino, found.st_size, found.st_mtim.tv_sec, found.st_mtim.tv_nsec};
}

struct Memory {
    static constexpr std::size_t most_files = 100'000;
    struct Reply {
        State state;
        bool is;
    };
    std::mutex mutex; ///< of what follows
    std::map<std::string, Reply> replies;
};

} // namespace

std::string new_token() {
    static_assert(std::random_device::min() == 0 && std::random_device::max() == 0xffffffffU);
    constexpr int num_words = 4;
    std::random_device words;
    std::string token;
    for (int i = 0; i < num_words; ++i)
        token += fmt::format("{:08x}", words());
    return token;
}

bool is_same(std::string_view one, std::string_view other) {
    unsigned difference = one.size() == other.size() ? 0U : 1U;
    for (std::size_t i = 0; i < std::min(one.size(), other.size()); ++i)
        difference |= static_cast<unsigned>(static_cast<unsigned char>(one[i]) ^ static_cast<unsigned char>(other[i]));
    return difference == 0U;
}

bool cookie_has_token(std::string_view cookies, std::uint16_t port, std::string_view token) {
    const auto start = cookie_name(port) + '=';
    while (!cookies.empty()) {
        auto cookie = cookies.substr(0, cookies.find(';'));
        cookies.remove_prefix(std::min(cookie.size() + 1, cookies.size()));
        cookie.remove_prefix(std::min(cookie.find_first_not_of(' '), cookie.size()));
        // Another server of this host may have set one of the same name; it is not for it to say who comes in here.
        if (cookie.starts_with(start) && is_same(cookie.substr(start.size()), token))
            return true;
    }
    return false;
}

std::string cookie_of_token(std::uint16_t port, std::string_view token) {
    return fmt::format("{}={}; Path=/; HttpOnly; SameSite=Strict", cookie_name(port), token);
}

Response respond(const Request &request, const Site &site) {
    if (auto refusal = refused(request, site, false))
        return std::move(*refusal);
    if (request.method != "GET" && request.method != "HEAD")
        return refusal(405, "This server only shows files.");
    const auto path = percent_decoded(request.target.substr(0, request.target.find('?')));
    if (!path)
        return not_well_formed();
    if (is_page(*path))
        return {.status = 200,
                .content_type = "text/html; charset=utf-8",
                .text = {},
                .file = site.page,
                .set_cookie = address_has_token(request, site) ? cookie_of_token(site.port, site.token) : ""};
    if (*path == "/files.json")
        return list(site);
    constexpr std::string_view files = "/files/", image = "/image/";
    const bool is_image = path->starts_with(image);
    if (!is_image && !path->starts_with(files))
        return not_there();
    auto file = shown_file(path->substr((is_image ? image : files).size()), site.folder);
    if (!file || !site.is_result_file(*file))
        return not_there();
    if (is_image)
        return image_for(*file, site);
    return {.status = 200, .content_type = "application/x-hdf5", .text = {}, .file = std::move(*file)};
}

std::variant<Opening, Response> opening(const Request &request, const Site &site) {
    if (auto refusal = refused(request, site, true))
        return std::move(*refusal);
    const auto path = percent_decoded(request.target.substr(0, request.target.find('?')));
    if (!path)
        return not_well_formed();
    const auto found = site.sessions.find(*path);
    if (found == site.sessions.end())
        return refusal(404, "There is no such session here.");
    try {
        auto query = parse_fields(query_of(request.target));
        query.erase("token");
        return Opening{found->second, std::move(query)};
    } catch (const support::InputError &) {
        return not_well_formed();
    }
}

std::optional<fs::path> shown_file(const std::string &path, const fs::path &folder) {
    return is_plain_path(path) ? file_of(path, folder) : std::nullopt;
}

ResultFiles result_files(const Site &site) {
    std::error_code error;
    ResultFiles found;
    for (auto entry =
             fs::recursive_directory_iterator(site.folder, fs::directory_options::skip_permission_denied, error);
         !error && entry != fs::recursive_directory_iterator(); entry.increment(error)) {
        const auto path = entry->path().lexically_relative(site.folder);
        const auto file = file_of(path, site.folder);
        bool is_one = false;
        try {
            is_one = file && site.is_result_file(*file);
        } catch (const support::InputError &) {
            ++found.num_in_use;
        }
        if (is_one) {
            if (auto name = path.generic_string(); is_utf8(name))
                found.paths.push_back(std::move(name));
            else
                ++found.num_not_utf8;
        }
    }
    if (error)
        throw support::InputError(
            fmt::format("{}: cannot be listed ({}); check its permissions", site.folder.string(), error.message()));
    std::ranges::sort(found.paths);
    return found;
}

AskAboutFile remembered(AskAboutFile ask) {
    return [ask = std::move(ask), memory = std::make_shared<Memory>()](const std::filesystem::path &path) {
        // Before the question: if the file changes in between, the next one asks again.
        const auto state = state_of(path);
        if (!state)
            return false;
        {
            const std::lock_guard lock(memory->mutex);
            if (const auto known = memory->replies.find(path.native());
                known != memory->replies.end() && known->second.state == *state)
                return known->second.is;
        }
        const bool is = ask(path);
        const std::lock_guard lock(memory->mutex);
        if (memory->replies.size() >= Memory::most_files)
            memory->replies.clear(); // names that are long gone
        memory->replies.insert_or_assign(path.native(), Memory::Reply{*state, is});
        return is;
    };
}

} // namespace livermark::server
