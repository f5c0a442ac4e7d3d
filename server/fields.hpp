#pragma once

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

} // namespace livermark::server
