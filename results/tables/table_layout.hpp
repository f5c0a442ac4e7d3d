#pragma once

#include <cstddef>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace livermark::results {

/// A number that has no value, which is "-" in a table.
inline constexpr double not_known = std::numeric_limits<double>::quiet_NaN();

struct Column {
    std::string title;
    bool is_number = false; ///< set to the right
};

/// Text in rows and columns.
struct Layout {
    std::vector<Column> columns;
    std::vector<std::vector<std::string>> rows; ///< a cell for each column
};

/// The same text with a question mark for each byte of a control character (C0, C1): what a file says of itself may
/// otherwise move the cursor of a terminal, or more.
std::string printable(std::string text);

/// Lines of equal width for a terminal, all printable().
std::string to_text(const Layout &layout);

/// A table in GitHub's Markdown, all printable().
std::string to_markdown(const Layout &layout);

/// A mean as it stands in a table: with the number of load cases behind it where it is not over all of them, "5.32 (3
/// of 11)": such a mean is not to be ranked.
std::string over_some(const std::string &mean, std::size_t part, std::size_t whole);

/// A number with some decimals; where that would be too wide, in the form 1.2e+34. "-" for NaN: nothing is known.
std::string fixed(double value, int decimals);

/// The same with some significant digits, such as 0.00123.
std::string significant(double value, int digits);

/// A table that is made column by column, so that each is named beside its cells. A cell is a text that a function
/// makes of a row, or a member of it.
template <class Row> class TableOf {
  public:
    explicit TableOf(std::vector<Row> rows) : rows_(std::move(rows)) { layout_.rows.resize(rows_.size()); }

    template <class Cell> void text(std::string title, Cell cell) { add({std::move(title), false}, cell); }
    template <class Cell> void number(std::string title, Cell cell) { add({std::move(title), true}, cell); }
    /// The value of a row times a factor, as fixed() has it.
    template <class Value> void number(std::string title, Value value, double factor, int decimals) {
        number(std::move(title), [&](const Row &row) { return fixed(factor * std::invoke(value, row), decimals); });
    }
    /// The same with a sign before positive values.
    template <class Value> void signed_number(std::string title, Value value, double factor, int decimals) {
        number(std::move(title), [&](const Row &row) {
            const double shown = factor * std::invoke(value, row);
            return shown > 0.0 ? fixed(shown, decimals).insert(0, 1, '+') : fixed(shown, decimals);
        });
    }
    const Layout &layout() const { return layout_; }

  private:
    template <class Cell> void add(Column column, Cell &cell) {
        layout_.columns.push_back(std::move(column));
        for (std::size_t r = 0; r < rows_.size(); ++r)
            layout_.rows[r].emplace_back(std::invoke(cell, rows_[r]));
    }

    std::vector<Row> rows_;
    Layout layout_;
};

} // namespace livermark::results
