#include "app/run_tables.hpp"

#include <fmt/format.h>

#include "results/overview.hpp"
#include "results/summary.hpp"
#include "results/table.hpp"

namespace livermark::app {

void print_tables(std::span<const results::Result> results, TableKind kind, bool markdown) {
    const bool is_all = kind == TableKind::all;
    auto print = [is_first = true](const std::string &table) mutable {
        fmt::print("{}{}", is_first ? "" : "\n", table);
        is_first = false;
    };
    const auto as_text = [&](const results::Layout &layout) {
        return markdown ? results::to_markdown(layout) : results::to_text(layout);
    };
    if (is_all || kind == TableKind::models)
        print(markdown ? results::markdown_table(results) : results::text_table(results));
    if (is_all || kind == TableKind::summary)
        print(as_text(results::summary(results)));
    if (kind == TableKind::overview || (is_all && results::has_several_poisson_ratios(results)))
        print(as_text(results::overview(results)));
    if (kind == TableKind::means)
        print(as_text(results::mean_errors(results)));
}

} // namespace livermark::app
