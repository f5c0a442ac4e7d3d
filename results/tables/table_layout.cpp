#include "results/tables/table_layout.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace livermark::results {

namespace {

/// Least number that would blow up the width of its column.
constexpr double largest_fixed = 1e5;

std::string escape_markdown(const std::string &cell) {
    std::string escaped;
    for (const char c : cell) {
        if (c == '|')
            escaped += '\\';
        escaped += c;
    }
    return escaped;
}

std::string text_line(const Layout &layout, const std::vector<std::string> &cells,
                      const std::vector<std::size_t> &width) {
    std::string line;
    for (std::size_t c = 0; c < cells.size(); ++c) {
        line += c == 0 ? "" : "  ";
        line += layout.columns[c].is_number ? fmt::format("{:>{}}", printable(cells[c]), width[c])
                                            : fmt::format("{:<{}}", printable(cells[c]), width[c]);
    }
    return line + "\n";
}

std::string markdown_line(const std::vector<std::string> &cells) {
    std::string line;
    for (const auto &cell : cells)
        line += fmt::format("| {} ", escape_markdown(printable(cell)));
    return line + "|\n";
}

std::vector<std::string> titles(const Layout &layout) {
    std::vector<std::string> titles;
    for (const auto &column : layout.columns)
        titles.push_back(column.title);
    return titles;
}

} // namespace

std::string printable(std::string text) {
    for (std::size_t i = 0; i < text.size(); ++i) {
        const auto byte = static_cast<unsigned char>(text[i]);
        const auto next = static_cast<unsigned char>(i + 1 < text.size() ? text[i + 1] : '\0');
        if (byte < 0x20U || byte == 0x7fU)
            text[i] = '?';
        else if (byte == 0xc2U && next >= 0x80U && next <= 0x9fU) // C1 in UTF-8
            text[i] = text[i + 1] = '?';
    }
    return text;
}

std::string to_text(const Layout &layout) {
    std::vector<std::size_t> width;
    std::vector<std::string> rules;
    for (std::size_t c = 0; c < layout.columns.size(); ++c) {
        width.push_back(layout.columns[c].title.size());
        for (const auto &row : layout.rows)
            width[c] = std::max(width[c], row[c].size());
        rules.emplace_back(width[c], '-');
    }
    auto text = text_line(layout, titles(layout), width) + text_line(layout, rules, width);
    for (const auto &row : layout.rows)
        text += text_line(layout, row, width);
    return text;
}

std::string to_markdown(const Layout &layout) {
    auto text = markdown_line(titles(layout));
    for (const auto &column : layout.columns)
        text += column.is_number ? "| ---: " : "| --- ";
    text += "|\n";
    for (const auto &row : layout.rows)
        text += markdown_line(row);
    return text;
}

std::string over_some(const std::string &mean, std::size_t part, std::size_t whole) {
    return part == whole ? mean : fmt::format("{} ({} of {})", mean, part, whole);
}

std::string fixed(double value, int decimals) {
    if (std::isnan(value))
        return "-";
    return std::abs(value) < largest_fixed || !std::isfinite(value) ? fmt::format("{:.{}f}", value, decimals)
                                                                    : fmt::format("{:.1e}", value);
}

std::string significant(double value, int digits) {
    return std::isnan(value) ? "-" : fmt::format("{:.{}g}", value, digits);
}

} // namespace livermark::results
