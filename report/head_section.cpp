#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <map>

#include "core/units.hpp"
#include "report/html.hpp"
#include "report/models_of_results.hpp"
#include "report/sections.hpp"
#include "results/tables/overview.hpp"

namespace livermark::report {

namespace {

using core::percent;

struct Part {
    const char *id;
    const char *title;
};
constexpr std::array parts{Part{"errors", "How far each model is off"},
                           Part{"large", "Deformations of surgical size"},
                           Part{"cohort", "Livers of other people"},
                           Part{"pictures", "What it looks like"},
                           Part{"cost", "Error against cost"},
                           Part{"poisson", "Error against Poisson's ratio"},
                           Part{"refinement", "Error against refinement"},
                           Part{"steps", "Time steps, predicted and observed"},
                           Part{"timings", "What a step takes"},
                           Part{"paper", "The seed paper beside this"},
                           Part{"numbers", "Every number, and where it comes from"}};

/// What is known of one body, over its load cases.
struct Finding {
    std::size_t num_cases = 0;
    std::map<std::string, std::vector<double>> springs; ///< errors by model
    std::vector<double> baseline, uncertainties;
};

Finding find(const ReportData &data, const std::string &label) {
    Finding found;
    for (const auto &result : data.results) {
        if (results::body_label(result, data.results) != label)
            continue;
        ++found.num_cases;
        if (result.reference_uncertainty)
            found.uncertainties.push_back(result.reference_uncertainty->relative_l2);
        for (const auto &model : result.models)
            if (const double error = error_of(model); std::isfinite(error)) {
                if (is_spring_model(model))
                    found.springs[model.name].push_back(error);
                else if (model.name == "fem_p1")
                    found.baseline.push_back(error);
            }
    }
    return found;
}

/// A mean that is one over all load cases, or "-".
std::string mean_of_all(const std::vector<double> &values, std::size_t num_cases) {
    return values.empty() || values.size() < num_cases ? "-" : results::fixed(percent * mean(values), 2);
}

/// A row for each body: the springs that are best in the mean, of those that came through every load case.
results::Layout findings(const ReportData &data, const std::vector<std::string> &labels) {
    results::Layout layout{{{"body"},
                            {"load cases", true},
                            {"nearest springs"},
                            {"mean error [%]", true},
                            {"of linear finite elements [%]", true},
                            {"uncertainty of the reference [%]", true}},
                           {}};
    for (const auto &label : labels) {
        const auto found = find(data, label);
        std::string best;
        for (const auto &[name, errors] : found.springs)
            if (errors.size() == found.num_cases && (best.empty() || mean(errors) < mean(found.springs.at(best))))
                best = name;
        layout.rows.push_back(
            {label, fmt::format("{}", found.num_cases), best.empty() ? "none solved every load case" : best,
             best.empty() ? "-" : mean_of_all(found.springs.at(best), found.num_cases),
             mean_of_all(found.baseline, found.num_cases), mean_of_all(found.uncertainties, found.num_cases)});
    }
    return layout;
}

std::string fact(const char *name, const std::string &text) {
    return fmt::format("<dt>{}</dt><dd>{}</dd>\n", name, escaped(text));
}

/// A sentence in which the files of a folder are named from there.
std::string below(const std::filesystem::path &folder, std::string sentence) {
    const auto start = (folder / "").string();
    for (auto at = sentence.find(start); at != std::string::npos; at = sentence.find(start, at))
        sentence.erase(at, start.size());
    return sentence;
}

} // namespace

std::string head(const ReportData &data) {
    std::string html =
        "<header>\n<h1>Livermark report</h1>\n<p class=\"lead\">The errors of mass-spring models against a "
        "finite element reference, their cost, and their longest stable time steps.</p>\n";
    const auto labels = body_labels(data.results);
    if (!labels.empty())
        html += figure("table", table_html(findings(data, labels)), "In short: means over the load cases of each body.",
                       {});
    html += "<dl class=\"facts\">\n";
    html += fact("Files", fmt::format("{} of runs, {} of cohorts, {} of stability, {} of histories, {} of timings",
                                      data.results.size() + data.large.size(), data.cohorts.size(),
                                      data.stability.size(), data.histories.size(), data.timings.size()));
    for (const auto &fault : data.faults)
        html += fact("Left out", below(data.folder, fault));
    if (!data.results.empty()) {
        const auto newest = std::ranges::max_element(
            data.results, {}, [](const results::Result &result) { return result.provenance.created; });
        html += fact("Newest run", fmt::format("{}, livermark {}, commit {}", newest->provenance.created,
                                               newest->provenance.software_version, newest->provenance.git_commit));
        html +=
            fact("Machine", fmt::format("{}, {} threads, {}, {}", newest->provenance.cpu, newest->provenance.threads,
                                        newest->provenance.compiler, newest->provenance.build_type));
    }
    html += "</dl>\n<nav>\n";
    for (const auto &part : parts)
        html += fmt::format("<a href=\"#{}\">{}</a>\n", part.id, escaped(part.title));
    return html + "</nav>\n</header>\n";
}

} // namespace livermark::report
