#include "cli/run_tables.hpp"

#include <fmt/format.h>
#include <functional>
#include <string>

#include "results/tables/median_errors.hpp"
#include "results/tables/overview.hpp"
#include "results/tables/summary.hpp"
#include "results/tables/table.hpp"
#include "support/input_error.hpp"

namespace livermark::cli {

namespace {

std::string medians_with_legend(std::span<const results::Result> results,
                                const std::function<std::string(const results::Layout &)> &as_text) {
    const auto layout = results::median_errors(results);
    if (layout.rows.empty())
        throw support::InputError("there is no static load case here to take a median of; give result files of "
                                  "`livermark run --static`");
    return as_text(layout) + "\n" + results::median_legend(results);
}

} // namespace

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
    if (kind == TableKind::medians || (is_all && results::has_several_load_cases(results)))
        print(medians_with_legend(results, as_text));
    if (kind == TableKind::means)
        print(as_text(results::mean_errors(results)));
}

} // namespace livermark::cli
