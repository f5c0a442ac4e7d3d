#include <algorithm>
#include <fmt/format.h>
#include <set>

#include "core/units.hpp"
#include "report/html.hpp"
#include "report/sections.hpp"
#include "report/strip_plot.hpp"
#include "results/tables/cohort_table.hpp"

namespace livermark::report {

namespace {

using core::percent;
using Statistics = std::vector<results::CohortStatistics>;

/// Those of one regime and Poisson's ratio are drawn in one plot.
std::vector<Statistics> plotted_together(const Statistics &all) {
    std::vector<Statistics> groups;
    for (const auto &statistics : all) {
        const auto same = std::ranges::find_if(groups, [&](const Statistics &group) {
            return group.front().regime == statistics.regime && group.front().poisson_ratio == statistics.poisson_ratio;
        });
        if (same == groups.end())
            groups.push_back({statistics});
        else
            same->push_back(statistics);
    }
    return groups;
}

Strip strip_of(const results::CohortStatistics &statistics) {
    Strip strip{.values = {},
                .median = percent * statistics.median,
                .median_low = percent * statistics.median_interval.low,
                .median_high = percent * statistics.median_interval.high};
    for (const auto &mean : statistics.means)
        strip.values.push_back(percent * mean.error);
    return strip;
}

/// Of the bodies that a model has errors on, in each half; the smaller median on the unseen half comes first.
StripPlot plot_of_cohort(const Statistics &statistics) {
    StripPlot plot{.title = fmt::format("Error of each body at Poisson's ratio {:g}", statistics.front().poisson_ratio),
                   .label = "mean relative L2 error over load cases [%]",
                   .strip_names = {"training", "unseen"},
                   .rows = {}};
    for (const auto &group : statistics) {
        auto row = std::ranges::find(plot.rows, group.model, &StripRow::name);
        if (row == plot.rows.end())
            row = plot.rows.insert(row, {group.model, std::vector<Strip>(plot.strip_names.size())});
        row->strips[group.half == plot.strip_names.front() ? 0 : 1] = strip_of(group);
    }
    std::erase_if(plot.rows, [](const StripRow &row) {
        return std::ranges::all_of(row.strips, [](const Strip &strip) { return strip.values.empty(); });
    });
    const auto order = [](const StripRow &row) {
        const auto &strip = row.strips.back().values.empty() ? row.strips.front() : row.strips.back();
        return strip.median;
    };
    std::ranges::stable_sort(plot.rows, {}, order);
    return plot;
}

std::string bodies_of(const results::Cohort &cohort) {
    const auto lesions = [](const results::CohortBody &body) { return body.lesions.size(); };
    const auto volume = [](const results::CohortBody &body) { return 1e3 * body.volume; };
    return fmt::format(
        "{} livers of {:.2f} to {:.2f} L with {} to {} lesions.", cohort.bodies.size(),
        volume(std::ranges::min(cohort.bodies, {}, volume)), volume(std::ranges::max(cohort.bodies, {}, volume)),
        lesions(std::ranges::min(cohort.bodies, {}, lesions)), lesions(std::ranges::max(cohort.bodies, {}, lesions)));
}

std::string html_of(const results::Cohort &cohort) {
    std::set<std::string> load_cases;
    for (const auto &error : cohort.errors)
        load_cases.insert(error.load_case);
    auto html = cohort.bodies.empty() ? std::string() : paragraph(bodies_of(cohort));
    for (const auto &statistics : plotted_together(results::cohort_statistics(cohort.errors))) {
        const auto plot = plot_of_cohort(statistics);
        const auto regime = core::to_string(statistics.front().regime);
        if (!plot.rows.empty())
            html += figure("figure", strip_plot_svg(plot),
                           fmt::format("Deformations of the {} regime: a marker for each body, a stroke for the median "
                                       "and a bar for its interval of 95 %. The smallest median comes first.",
                                       regime),
                           {cohort.provenance.command});
        html += figure("table", table_html(results::cohort_table(statistics)),
                       fmt::format("Deformations of the {} regime: mean relative L2 error over load cases, in brackets "
                                   "the interval of 95 % by bootstrap. Load cases: {}.",
                                   regime, fmt::join(load_cases, ", ")),
                       {cohort.provenance.command});
    }
    for (const auto &failure : cohort.failures)
        html += missing("Failed: " + failure);
    return html;
}

} // namespace

std::string cohort_section(const ReportData &data) {
    constexpr auto *title = "Livers of other people";
    if (data.cohorts.empty())
        return section("cohort", title,
                       missing("There is no cohort file here.", "livermark cohort --bodies 1-8 --output FOLDER"));
    auto html = paragraph(
        "Errors over the bodies of a cohort. Constants of models may be chosen on the training half; accuracy is "
        "quoted on the unseen half. The other sections leave these bodies out: a report of the folder of one "
        "body shows it in full.");
    for (const auto &cohort : data.cohorts)
        html += html_of(cohort);
    return section("cohort", title, html);
}

} // namespace livermark::report
