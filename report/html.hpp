#pragma once

#include <cstdint>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "results/tables/table_layout.hpp"

/// The few pieces of HTML that a report is made of. All of it is well-formed XML as well, and texts are escaped here
/// and nowhere else: functions that take a text take it as it is, and those that take a `content` take HTML.
namespace livermark::report {

/// A text that means itself in HTML, between tags and in attributes. Bytes that are no UTF-8 and control characters
/// become U+FFFD.
std::string escaped(std::string_view text);

/// Escaped, and free to break behind each underscore.
std::string name_html(std::string_view name);

std::string paragraph(std::string_view text);

/// Says in its place that something is not there, and what makes it.
std::string missing(std::string_view what, std::string_view command = {});

/// A row and a column of a table.
using Cell = std::pair<std::size_t, std::size_t>;

/// A last column of a table that is not text.
struct HtmlColumn {
    std::string title;
    std::vector<std::string> contents; ///< one for each row
};

/// @param strong  cells in bold type
/// @param last    none without a title
std::string table_html(const results::Layout &layout, const std::set<Cell> &strong = {}, const HtmlColumn &last = {});

/// A figure or table with its caption; numbered by the style sheet.
/// @param kind      "figure" or "table", and " matrix" behind it for many columns, whose titles then stand upright
/// @param caption   a text
/// @param commands  that make what is shown again, a line each; several of one are shown once
std::string figure(std::string_view kind, std::string_view content, std::string_view caption,
                   const std::vector<std::string> &commands);

/// @param id  the target of links: letters and dashes
std::string section(std::string_view id, std::string_view title, std::string_view content);

/// A part of a section.
std::string subsection(std::string_view title, std::string_view content);

/// @param png  the bytes of a file
/// @param alt  what it shows, in words
std::string image(std::span<const std::uint8_t> png, int width, int height, std::string_view alt);

/// A command line without the folders of the program: where somebody has built it is nobody's business.
/// @param command  a text
std::string shown_command(std::string_view command);

/// The whole file.
/// @param style  CSS without '<' and '&'
std::string page(std::string_view title, std::string_view style, std::string_view content);

} // namespace livermark::report
