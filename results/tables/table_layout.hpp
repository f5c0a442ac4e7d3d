#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace livermark::results {

struct Column {
    std::string title;
    bool is_number = false; ///< set to the right
};

/// Text in rows and columns.
struct Layout {
    std::vector<Column> columns;
    std::vector<std::vector<std::string>> rows; ///< a cell for each column
};

/// A table without rows: columns of texts, then of numbers, then of texts.
Layout headed(const std::vector<std::string> &texts, const std::vector<std::string> &numbers,
              const std::vector<std::string> &last_texts = {});

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

} // namespace livermark::results
