#include "report/html.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>

namespace livermark::report {

namespace {

constexpr std::string_view replacement = "\xef\xbf\xbd";

bool is_continuation(char byte) {
    return (static_cast<unsigned char>(byte) & 0xc0U) == 0x80U;
}

/// Length of the UTF-8 sequence that the text begins with; 0 if it is none that XML may hold.
std::size_t sequence_length(std::string_view text) {
    const auto lead = static_cast<unsigned char>(text.front());
    if (lead < 0x80U)
        return lead >= 0x20U ? (lead == 0x7fU ? 0 : 1) : (lead == '\n' || lead == '\t' ? 1 : 0);
    const std::size_t length = lead >= 0xf0U && lead <= 0xf4U ? 4 : lead >= 0xe0U ? 3 : 2;
    if (lead < 0xc2U || lead > 0xf4U || text.size() < length ||
        !std::all_of(text.begin() + 1, text.begin() + static_cast<std::ptrdiff_t>(length), is_continuation))
        return 0;
    const auto second = static_cast<unsigned char>(text[1]);
    const bool is_overlong = (lead == 0xe0U && second < 0xa0U) || (lead == 0xf0U && second < 0x90U);
    const bool is_beyond = lead == 0xf4U && second > 0x8fU;
    const bool is_surrogate = lead == 0xedU && second > 0x9fU;
    const bool is_no_character = lead == 0xefU && second == 0xbfU && static_cast<unsigned char>(text[2]) > 0xbdU;
    return is_overlong || is_beyond || is_surrogate || is_no_character ? 0 : length;
}

std::string escaped_character(char c) {
    switch (c) {
    case '&':
        return "&amp;";
    case '<':
        return "&lt;";
    case '>':
        return "&gt;";
    case '"':
        return "&quot;";
    case '\'':
        return "&#39;";
    default:
        return {c};
    }
}

std::string base64(std::span<const std::uint8_t> bytes) {
    constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
        std::uint32_t group = 0;
        for (std::size_t b = 0; b < 3; ++b)
            group = (group << 8U) | (b < count ? bytes[i + b] : 0U);
        for (std::size_t d = 0; d < 4; ++d)
            text += d <= count ? digits[(group >> (18U - 6U * d)) & 63U] : '=';
    }
    return text;
}

std::string cell_html(std::string_view tag, bool is_number, bool is_strong, const std::string &content) {
    return fmt::format("<{0}{1}>{2}{3}{4}</{0}>", tag, is_number ? " class=\"number\"" : "",
                       is_strong ? "<strong>" : "", content, is_strong ? "</strong>" : "");
}

} // namespace

std::string escaped(std::string_view text) {
    std::string html;
    while (!text.empty()) {
        const auto length = sequence_length(text);
        if (length == 1)
            html += escaped_character(text.front());
        else
            html += length == 0 ? replacement : text.substr(0, length);
        text.remove_prefix(std::max<std::size_t>(1, length));
    }
    return html;
}

std::string name_html(std::string_view name) {
    std::string html;
    for (const char c : escaped(name)) {
        html += c;
        if (c == '_')
            html += "<wbr/>";
    }
    return html;
}

std::string paragraph(std::string_view text) {
    return fmt::format("<p>{}</p>\n", escaped(text));
}

std::string missing(std::string_view what, std::string_view command) {
    return fmt::format("<p class=\"missing\">{}{}</p>\n", escaped(what),
                       command.empty() ? "" : fmt::format(" Made by <code>{}</code>.", escaped(command)));
}

std::string table_html(const results::Layout &layout, const std::set<Cell> &strong, const HtmlColumn &last) {
    std::string html = "<div class=\"wide\"><table>\n<thead><tr>";
    for (const auto &column : layout.columns)
        html += cell_html("th", column.is_number, false, name_html(column.title));
    if (!last.title.empty())
        html += cell_html("th", false, false, escaped(last.title));
    html += "</tr></thead>\n<tbody>\n";
    for (std::size_t r = 0; r < layout.rows.size(); ++r) {
        html += "<tr>";
        for (std::size_t c = 0; c < layout.columns.size(); ++c)
            html += cell_html("td", layout.columns[c].is_number, strong.contains({r, c}), escaped(layout.rows[r][c]));
        if (!last.title.empty())
            html += cell_html("td", false, false, last.contents[r]);
        html += "</tr>\n";
    }
    return html + "</tbody></table></div>\n";
}

std::string figure(std::string_view kind, std::string_view content, std::string_view caption,
                   const std::vector<std::string> &commands) {
    std::string lines;
    std::set<std::string> shown;
    for (const auto &command : commands)
        if (shown.insert(command).second)
            lines += fmt::format("<code>{}</code>", escaped(shown_command(command)));
    return fmt::format("<figure class=\"{}\">\n{}<figcaption>{}{}</figcaption>\n</figure>\n", kind, content,
                       escaped(caption), lines.empty() ? "" : fmt::format("<span class=\"made\">{}</span>", lines));
}

std::string section(std::string_view id, std::string_view title, std::string_view content) {
    return fmt::format("<section id=\"{}\">\n<h2>{}</h2>\n{}</section>\n", id, escaped(title), content);
}

std::string subsection(std::string_view title, std::string_view content) {
    return fmt::format("<h3>{}</h3>\n{}", name_html(title), content);
}

std::string image(std::span<const std::uint8_t> png, int width, int height, std::string_view alt) {
    return fmt::format("<img width=\"{}\" height=\"{}\" alt=\"{}\" src=\"data:image/png;base64,{}\"/>", width, height,
                       escaped(alt), base64(png));
}

std::string shown_command(std::string_view command) {
    constexpr std::string_view program = "/livermark ";
    const auto end_of_folders = command.find(program);
    return std::string(end_of_folders == std::string_view::npos ? command : command.substr(end_of_folders + 1));
}

std::string page(std::string_view title, std::string_view style, std::string_view content) {
    return fmt::format("<!DOCTYPE html>\n"
                       "<html lang=\"en\" xmlns=\"http://www.w3.org/1999/xhtml\">\n<head>\n<meta charset=\"utf-8\"/>\n"
                       "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n"
                       "<title>{}</title>\n<style>\n{}</style>\n</head>\n<body>\n<main>\n{}</main>\n</body>\n</html>\n",
                       escaped(title), style, content);
}

} // namespace livermark::report
