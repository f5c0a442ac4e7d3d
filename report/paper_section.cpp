#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>

#include "report/html.hpp"
#include "report/plot.hpp"
#include "report/sections.hpp"
#include "results/tables/history_table.hpp"

namespace livermark::report {

namespace {

/// What leaves this on either side ends there with a cross, as on the paper's axes.
constexpr double largest_shown = 1.6;

/// Of what is let go, and not of what is pushed: that is the same upside down.
bool is_let_go(const results::HistoryCase &entry) {
    return !entry.name.ends_with("_step_force");
}

std::string table_1(const std::vector<PaperTable> &tables) {
    if (tables.empty())
        return missing("No result file here has the springs of lloyd on a body that may be a liver.", "livermark run");
    std::string html;
    for (const auto &table : tables) {
        html +=
            figure("table", table_html(table.rows),
                   fmt::format("Table 1 of the paper beside {}: each printed number in every unit that it could have.",
                               table.body),
                   {table.command});
        std::string sentences;
        for (const auto &objection : table.objections)
            sentences += fmt::format("<li>{}.</li>\n", escaped(objection));
        if (!sentences.empty())
            html += "<ul>\n" + sentences + "</ul>\n";
    }
    return html;
}

/// One step length: the line up to where it leaves the panel, and a cross where it does or diverges.
void add_series(Plot &plot, const results::HistoryCase &entry, std::size_t step, double duration) {
    constexpr std::array colours{"#d55e00", "#e69f00", "#0072b2", "#111111", "#009e73"};
    constexpr std::array dashes{"2 3", "8 3 2 3", "7 4", "", ""};
    const auto &history = entry.steps[step];
    const auto *const colour = colours[step % colours.size()];
    Series line{.name = fmt::format("h = {:.3g} s: {}", history.time_step,
                                    std::isnan(history.diverged_at) ? "stable" : "diverges"),
                .points = {},
                .style = {colour, Marker::none, true, dashes[step % dashes.size()]}};
    bool has_left = !std::isnan(history.diverged_at);
    for (std::size_t k = 0; k < history.time.size(); ++k) {
        const double relative = history.displacement[k] / history.displacement.front();
        const double shown = std::clamp(std::isnan(relative) ? largest_shown : relative, -largest_shown, largest_shown);
        line.points.push_back({history.time[k], shown});
        if (shown != relative) {
            has_left = true;
            break;
        }
    }
    if (has_left && !line.points.empty()) {
        auto end = line.points.back();
        end.x = std::min(end.x, duration);
        plot.series.push_back({.name = {}, .points = {end}, .style = {colour, Marker::cross, false}});
    }
    plot.series.push_back(line);
}

Plot plot_of(const results::HistoryCase &entry) {
    double duration = 0.0;
    for (const auto &history : entry.steps)
        duration = std::max(duration, history.time.back());
    Plot plot{.title = entry.title,
              .x = {.label = fmt::format("t [s], square root scale; steps up to {:.4g} s are stable",
                                         entry.critical_time_step),
                    .scale = Scale::square_root,
                    .low = 0.0,
                    .high = duration},
              .y = {.label = "u / u(0)", .low = -largest_shown, .high = largest_shown},
              .series = {},
              .height = 250.0,
              .names = Names::key};
    for (std::size_t step = 0; step < entry.steps.size(); ++step)
        add_series(plot, entry, step, duration);
    return plot;
}

/// How many of some motions were stable in steps of some length, as "3 of 6"; "-" if none took such a step.
std::string share(const std::vector<const results::HistoryCase *> &cases, double time_step) {
    int stable = 0, all = 0;
    for (const auto *entry : cases)
        for (const auto &history : entry->steps)
            if (std::abs(history.time_step / time_step - 1.0) < 1e-9) {
                ++all;
                stable += std::isnan(history.diverged_at) && history.time_step <= entry->critical_time_step ? 1 : 0;
            }
    return all == 0 ? "-" : fmt::format("{} of {}", stable, all);
}

std::string verdicts(const std::vector<results::Histories> &all) {
    std::vector<const results::HistoryCase *> without, with, bodies;
    for (const auto &histories : all)
        for (const auto &entry : histories.cases)
            if (is_let_go(entry))
                (histories.subject != "one_degree_of_freedom"             ? bodies
                 : entry.name.find("without_tumour") != std::string::npos ? without
                                                                          : with)
                    .push_back(&entry);
    results::Layout layout{{{"step"},
                            {"the paper says"},
                            {"one degree of freedom, without tumours", true},
                            {"with tumours", true},
                            {"whole bodies", true}},
                           {}};
    const auto add = [&](double step, const char *claim) {
        layout.rows.push_back(
            {fmt::format("h = {:g} s", step), claim, share(without, step), share(with, step), share(bodies, step)});
    };
    add(0.005, "stable, without and with tumours");
    add(0.05, "-");
    add(0.5, "-");
    add(1.0, "stable for neither");
    return figure(
        "table", table_html(layout),
        "How many motions are stable in the steps of Figures 5 and 6, beside what the paper says of them. Those "
        "of one degree of freedom differ in what the units of Table 1 are read as.",
        {});
}

std::string figures_5_and_6(const std::vector<results::Histories> &all) {
    std::string plots;
    std::vector<std::string> commands;
    std::vector<results::Histories> let_go = all;
    for (auto &histories : let_go) {
        std::erase_if(histories.cases, [](const auto &entry) { return !is_let_go(entry); });
        commands.push_back(histories.provenance.command);
        for (const auto &entry : histories.cases)
            if (!entry.steps.empty())
                plots += plot_svg(plot_of(entry));
    }
    return verdicts(all) +
           figure("figure", "<div class=\"plots\">\n" + plots + "</div>\n",
                  "What Figures 5 and 6 of the paper show: its model of one degree of freedom in four time steps, once "
                  "for "
                  "each reading of its units, and whole bodies, whose probe is drawn relative to where it started. A "
                  "cross "
                  "is where a motion leaves the panel or diverges.",
                  commands) +
           figure("table", table_html(results::history_table(let_go)), "The same in words.", {});
}

} // namespace

std::string paper_section(const ReportData &data, const std::vector<PaperTable> &tables) {
    auto html = fmt::format(
        "<p><cite>Integrating biomechanical parameters in modeling of liver with and without tumor in virtual "
        "environment</cite>, Jurnal Teknologi 75, <a href=\"https://doi.org/10.11113/jt.v75.5068\">10.11113/jt.v75.5068"
        "</a>, puts a mass-spring model on two livers, which are not those that are here.</p>\n");
    html += subsection("Table 1", table_1(tables));
    html += subsection("Figures 5 and 6", data.histories.empty()
                                              ? missing("There are no history files here.", "livermark histories")
                                              : figures_5_and_6(data.histories));
    return section("paper", "The seed paper beside this", html);
}

} // namespace livermark::report
