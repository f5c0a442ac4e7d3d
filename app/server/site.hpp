#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "app/server/session.hpp"

/// Token that tells who may ask a server from everybody else on this machine: a token in the address that it prints,
/// which the first visit turns into a cookie.
namespace livermark::server {

/// 128 random bits of the system's generator, as 32 hexadecimal digits.
std::string new_token();

/// Whether two texts are the same, in a time that does not say where they differ.
bool is_same(std::string_view one, std::string_view other);

/// Whether the value of a Cookie header has the token of the server at a port. Browsers keep cookies by host and not
/// by port, so the cookie's name has the port: several servers on one machine do not take theirs from each other.
/// A page that another program of this machine has a browser visit is sent the cookie as well: do not follow addresses
/// of 127.0.0.1 that are not yours.
bool cookie_has_token(std::string_view cookies, std::uint16_t port, std::string_view token);

/// The value of the Set-Cookie header: no script may read it, and no other site has it sent.
std::string cookie_of_token(std::uint16_t port, std::string_view token);

/// The view that a browser on this machine has of a folder of result files: the page, the list of the files, the files,
/// and the sessions about them.

struct Site {
    std::filesystem::path folder; ///< with the result files; absolute, without symlinks and dots
    std::filesystem::path page;   ///< index.html
    std::uint16_t port;           ///< that the browser has to name
    std::string token;            ///< see new_token(); an empty one lets nobody in
    /// Asked of each .h5 file that is to be listed or sent, by several threads; see remembered(). May throw InputError
    /// where nobody can say now.
    std::function<bool(const std::filesystem::path &)> is_result_file;
    /// JSON of the label image that the body of a result file was made of; called by several threads. Throws InputError
    /// with why there is none.
    std::function<std::string(const std::filesystem::path &)> image_of{};
    std::map<std::string, BeginSession> sessions{}; ///< by the path that WebSockets ask for
};

/// The lines of an HTTP request that decide on its response.
struct Request {
    std::string method;
    std::string target;                      ///< path as the browser sends it, percent-encoded
    std::string host;                        ///< empty if it is missing
    std::optional<std::string> origin;       ///< of the page that asks, which browsers leave out where it is the same
    std::optional<std::string> fetch_site{}; ///< Sec-Fetch-Site: what the browser knows of the page that asks
    std::string cookies{};                   ///< empty if there are none
};

struct Response {
    int status; ///< of HTTP
    std::string content_type;
    std::string text;           ///< what to send, unless there is a file
    std::filesystem::path file; ///< what to send, absolute; empty for text
    std::string set_cookie{};   ///< of who came with the token in the address; empty for none
};

/// Decides on a request. `/` is the page, `/files.json` the list of the result files as [{"path":"...","bytes":0}],
/// and `/files/<path>` one of them, which has to end in .h5, lie below the folder once symlinks are followed, and be a
/// result file. `/image/<path>` is the label image that its body was made of, or a sentence on why there is none. It
/// reads the folder, and changes nothing.
///
/// Any page of the web may send requests to a port of this machine, so Host, and Origin where there is one, have to be
/// exactly 127.0.0.1:PORT or localhost:PORT (at port 80 also without it), and Sec-Fetch-Site, where there is one,
/// `same-origin` or `none`. Any user of this machine may as well, so each request needs the token: in its address as
/// `?token=...`, or in the cookie that such a visit to the page sets. A link of another site may lead to the page with
/// the token.
Response respond(const Request &request, const Site &site);

/// Session to begin on a WebSocket.
struct Opening {
    BeginSession begin;
    Fields query; ///< without the token
};

/// Decides on a request to upgrade to a WebSocket. All has to be as for respond(), and here Origin has to be there:
/// every browser sends it, and what a WebSocket says is not withheld from other pages as a file is.
/// @return the refusal, if the path is not one of site.sessions or anything else is wrong
std::variant<Opening, Response> opening(const Request &request, const Site &site);

/// A file as `/files/<path>` gives it where it is a result file, which is not looked at here.
/// @param path  relative to the folder, not encoded
/// @return absolute and without symlinks; nothing if the server does not show it
std::optional<std::filesystem::path> shown_file(const std::string &path, const std::filesystem::path &folder);

struct ResultFiles {
    /// Relative to the folder, with '/', by name.
    std::vector<std::string> paths;
    int num_not_utf8 = 0; ///< how many more there are whose names are no UTF-8: no address can name them
    int num_in_use = 0;   ///< how many files could be, but another program has them open to write
};

/// The result files below the folder.
/// @throws support::InputError if the folder cannot be listed
ResultFiles result_files(const Site &site);

using AskAboutFile = std::function<bool(const std::filesystem::path &)>;

/// Asks once about each file until it changes (inode, size, time of the last change), and keeps the reply: a file with
/// thousands of models takes seconds to be told from others. Copies share what they keep, and threads may ask at once.
AskAboutFile remembered(AskAboutFile ask);

/// Times that the server waits for others.
struct Patience {
    /// Silence after which the other side of a WebSocket is asked whether it is there, and given up without a sign of
    /// life.
    std::chrono::milliseconds silence = std::chrono::seconds(15);
    /// Silence after which a session that waits for a message yields to a new one, where there are as many as may be.
    std::chrono::milliseconds until_replaced = std::chrono::seconds(10);
};

/// Answers requests to 127.0.0.1 until SIGINT or SIGTERM comes. Open WebSockets are closed then. Where one of them is
/// still working a reply out after a second, the whole program ends here, with status 0: a solve cannot be broken off,
/// and nothing that is worth keeping goes with it.
///
/// At most 64 connections and eight WebSockets are open at a time; one that has been silent, or does not take what is
/// sent, yields to a new one. Where the system has no descriptor left, new ones wait. Descriptors do not go to programs
/// that this one starts.
/// @param site      its port is the one to listen on; 0 takes any that is free
/// @param is_ready  called once, with the port, when requests are answered
/// @throws support::InputError if the port cannot be had
void serve(Site site, const std::function<void(std::uint16_t port)> &is_ready, const Patience &patience = {});

} // namespace livermark::server
