#include "results/grid.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace livermark::results {

namespace {

/// The titles, then the rows.
std::vector<std::vector<std::string>> lines_of(const Grid &grid) {
    std::vector<std::vector<std::string>> lines(1);
    for (const auto &column : grid.columns)
        lines[0].push_back(column.title);
    lines.insert(lines.end(), grid.rows.begin(), grid.rows.end());
    return lines;
}

std::string escape_markdown(const std::string &cell) {
    std::string escaped;
    for (const char c : cell) {
        if (c == '|')
            escaped += '\\';
        escaped += c;
    }
    return escaped;
}

} // namespace

std::string text_grid(const Grid &grid) {
    const auto lines = lines_of(grid);
    std::vector<std::size_t> width(grid.columns.size(), 0);
    for (const auto &line : lines)
        for (std::size_t c = 0; c < width.size(); ++c)
            width[c] = std::max(width[c], line[c].size());

    std::string text;
    for (const auto &line : lines) {
        for (std::size_t c = 0; c < width.size(); ++c) {
            text += c == 0 ? "" : "  ";
            text += grid.columns[c].is_number ? fmt::format("{:>{}}", line[c], width[c])
                                              : fmt::format("{:<{}}", line[c], width[c]);
        }
        text += '\n';
        if (&line == &lines.front()) {
            for (std::size_t c = 0; c < width.size(); ++c)
                text += fmt::format("{}{:-<{}}", c == 0 ? "" : "  ", "", width[c]);
            text += '\n';
        }
    }
    return text;
}

std::string markdown_grid(const Grid &grid) {
    const auto lines = lines_of(grid);
    std::string text;
    for (const auto &line : lines) {
        for (const auto &cell : line)
            text += fmt::format("| {} ", escape_markdown(cell));
        text += "|\n";
        if (&line == &lines.front()) {
            for (const auto &column : grid.columns)
                text += column.is_number ? "| ---: " : "| --- ";
            text += "|\n";
        }
    }
    return text;
}

} // namespace livermark::results
