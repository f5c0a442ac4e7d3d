#include <fmt/format.h>

#include "report/html.hpp"
#include "report/sections.hpp"
#include "results/tables/overview.hpp"
#include "results/tables/table.hpp"

namespace livermark::report {

namespace {

std::string files_table(const ReportData &data) {
    results::Layout layout{{{"file"}, {"body"}, {"load case"}, {"commit"}, {"created"}, {"build"}}, {}};
    for (std::size_t r = 0; r < data.results.size(); ++r) {
        const auto &result = data.results[r];
        layout.rows.push_back({data.files[r], results::body_label(result, data.results), result.problem.load_case.title,
                               result.provenance.git_commit.substr(0, 12), result.provenance.created,
                               result.provenance.build_type});
    }
    return table_html(layout);
}

std::string assumptions(const ReportData &data) {
    std::set<std::string> sentences;
    for (const auto &result : data.results)
        for (const auto &assumption : result.problem.body->assumptions)
            sentences.insert(fmt::format("{}: {}", result.problem.body->name, assumption));
    std::string html;
    for (const auto &sentence : sentences)
        html += fmt::format("<li>{}</li>\n", escaped(sentence));
    return html.empty() ? html : subsection("Assumed of bodies", "<ul>\n" + html + "</ul>\n");
}

} // namespace

std::string appendix(const ReportData &data, const std::string &command_line) {
    std::string html;
    if (!data.results.empty())
        html +=
            fmt::format("<div class=\"small\">\n{}{}</div>\n",
                        figure("table", table_html(results::error_table(data.results)),
                               "Every model under every load case: peak displacement, errors, uncertainty of the "
                               "reference (+-), nonlinearity, times, and whether the error is in the band expected for "
                               "it.",
                               {}),
                        figure("table", files_table(data), "The result files.", {}));
    html += assumptions(data);
    std::string others;
    for (const auto &other : data.others)
        others += fmt::format("<li>{}</li>\n", escaped(other));
    if (!others.empty())
        html += subsection("Files that are not shown",
                           paragraph("Modes, calibrations and exported problems are not part of this report.") +
                               "<ul>\n" + others + "</ul>\n");
    html += subsection("To make this report again",
                       fmt::format("<p><code>{}</code></p>\n", escaped(shown_command(command_line))));
    return section("numbers", "Every number, and where it comes from", html);
}

} // namespace livermark::report
