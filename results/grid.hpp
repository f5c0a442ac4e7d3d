#pragma once

#include <string>
#include <vector>

namespace livermark::results {

struct GridColumn {
    std::string title;
    bool is_number; ///< numbers stand at the right of their column
};

/// Cells of text under titles.
struct Grid {
    std::vector<GridColumn> columns;
    std::vector<std::vector<std::string>> rows; ///< as many cells each as there are columns
};

/// Lines of aligned columns for a terminal, the titles underlined.
std::string text_grid(const Grid &grid);

/// The same in GitHub's Markdown.
std::string markdown_grid(const Grid &grid);

} // namespace livermark::results
