#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "server/conversation.hpp"

/// What a browser on this machine may see of a folder of result files: the page, the list of the files, the files, and
/// the conversations about them.
namespace livermark::server {

struct Site {
    std::filesystem::path folder; ///< with the result files; absolute, without symlinks and dots
    std::filesystem::path page;   ///< index.html
    std::uint16_t port;           ///< that the browser has to name
    std::function<bool(const std::filesystem::path &)> is_result_file; ///< asked of each .h5 file that is to be listed
    std::map<std::string, BeginConversation> conversations{};          ///< by the path that WebSockets ask for
};

/// The lines of an HTTP request that decide on its answer.
struct Request {
    std::string method;
    std::string target;                ///< path as the browser sends it, percent-encoded
    std::string host;                  ///< empty if it is missing
    std::optional<std::string> origin; ///< of the page that asks, which browsers leave out where it is the same
};

struct Answer {
    int status; ///< of HTTP
    std::string content_type;
    std::string text;           ///< what to send, unless there is a file
    std::filesystem::path file; ///< what to send, absolute; empty for text
};

/// Decides on a request. `/` is the page, `/files.json` the list of the result files as [{"path":"...","bytes":0}],
/// and `/files/<path>` one of them, which has to end in .h5 and lie below the folder once symlinks are followed.
/// Any page of the web may send requests to a port of this machine, so Host, and Origin where there is one, have to be
/// exactly 127.0.0.1:PORT or localhost:PORT. It reads the folder, and changes nothing.
Answer answer(const Request &request, const Site &site);

/// What to begin on a WebSocket.
struct Opening {
    BeginConversation begin;
    Fields query;
};

/// Decides on a request to upgrade to a WebSocket. Host and Origin have to be as for answer(), and here Origin has to
/// be there: every browser sends it, and what a WebSocket says is not withheld from other pages as a file is.
/// @return the refusal, if the path is not one of site.conversations or anything else is wrong
std::variant<Opening, Answer> opening(const Request &request, const Site &site);

/// A file as `/files/<path>` gives it.
/// @param path  relative to the folder, not encoded
/// @return absolute and without symlinks; nothing if the server does not show it
std::optional<std::filesystem::path> shown_file(const std::string &path, const std::filesystem::path &folder);

/// Paths of the result files below the folder, relative to it, with '/', by name.
/// @throws core::InputError if the folder cannot be listed
std::vector<std::string> result_files(const Site &site);

} // namespace livermark::server
