#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// Text of the form a=b&c=d, as URLSearchParams in a browser writes and reads it: the query of an address, and the text
/// messages of a WebSocket.
namespace livermark::server {

using Fields = std::map<std::string, std::string>; ///< values by name, decoded

/// @return nothing if a % is not followed by two hexadecimal digits
std::optional<std::string> percent_decoded(std::string_view text);

/// @param text  may be empty; a name without '=' has an empty value
/// @throws support::InputError if it is not well formed, or has a name twice
Fields parse_fields(std::string_view text);

/// The inverse of parse_fields(), in the order of the names: letters, digits, '*', '-', '.' and '_' as they are, a
/// space as '+', every other byte as %XX.
std::string fields_text(const Fields &fields);

/// @throws support::InputError if the name is missing, or its value empty
const std::string &required_text(const Fields &fields, const std::string &name);

/// @param smallest, largest  both allowed
/// @throws support::InputError if the name is missing, or its value not a number between the two
double required_number(const Fields &fields, const std::string &name, double smallest, double largest);

/// @return those between the commas of a value
/// @throws support::InputError if the name is missing, or one of them not a finite number
std::vector<double> required_numbers(const Fields &fields, const std::string &name);

/// A message over a WebSocket.
struct Message {
    bool is_binary = false; ///< else UTF-8
    std::string bytes;
};

/// Replies to a message. What the other side did wrong is a support::InputError, which goes out as the text
/// `fault=<sentence>`, and the session goes on; any other exception closes the socket. It stays in one thread,
/// while other sessions, and the pages, are served by theirs.
using Session = std::function<Message(const Message &)>;

/// Reports to the other side what a reply is waiting for, as the text `progress=<sentence>` before it: any number of
/// them, which are no replies. Only while a session begins or works out a reply, and in its thread. It returns whether
/// the reply is still waited for: not once the other side has sent another message, or has gone. A session may then end
/// its work with a shorter reply.
using ReportProgress = std::function<bool(const std::string &sentence)>;

/// Begins a session from the query of its address, in the thread in which it will stay. A support::InputError is the
/// reply to every message then: browsers do not show why a WebSocket was refused.
/// @param report  lives as long as the session
using BeginSession = std::function<Session(const Fields &query, const ReportProgress &report)>;

} // namespace livermark::server
