#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <map>

#include "report/contestants.hpp"
#include "report/html.hpp"
#include "report/sections.hpp"
#include "results/overview.hpp"

namespace livermark::report {

namespace {

constexpr double percent = 100.0;

struct Part {
    const char *id;
    const char *title;
};
constexpr std::array parts{Part{"errors", "How far each model is off"},
                           Part{"pictures", "What it looks like"},
                           Part{"cost", "Error against cost"},
                           Part{"poisson", "Error against Poisson's ratio"},
                           Part{"refinement", "Error against refinement"},
                           Part{"steps", "Time steps, predicted and observed"},
                           Part{"timings", "What a step takes"},
                           Part{"paper", "The seed paper beside this"},
                           Part{"numbers", "Every number, and where it comes from"}};

/// The contestant that is best in the mean over the load cases of a body that it came through, all of them.
std::string finding(const ReportData &data, const std::string &label) {
    std::map<std::string, std::vector<double>> errors;
    std::size_t num_cases = 0;
    std::vector<double> uncertainties;
    for (const auto &result : data.results) {
        if (results::body_label(result, data.results) != label)
            continue;
        ++num_cases;
        if (result.reference_uncertainty)
            uncertainties.push_back(result.reference_uncertainty->relative_l2);
        for (const auto &model : result.models)
            if ((is_contestant(model) || model.name == "fem_p1") && std::isfinite(error_of(model)))
                errors[model.name].push_back(error_of(model));
    }
    std::string best;
    for (const auto &[name, values] : errors)
        if (name != "fem_p1" && values.size() == num_cases && (best.empty() || mean(values) < mean(errors.at(best))))
            best = name;
    if (best.empty())
        return fmt::format("<li><strong>{}</strong>: no springs came through every load case.</li>\n",
                           name_html(label));
    auto text = fmt::format("<li><strong>{}</strong>: of the springs, {} are nearest to the reference: {:.1f} % off in "
                            "the mean over {} load case{}",
                            name_html(label), name_html(best), percent * mean(errors.at(best)), num_cases,
                            num_cases == 1 ? "" : "s");
    if (errors.contains("fem_p1") && errors.at("fem_p1").size() == num_cases)
        text += fmt::format("; linear finite elements on the same mesh are {:.1f} % off",
                            percent * mean(errors.at("fem_p1")));
    if (!uncertainties.empty())
        text += fmt::format("; the reference itself is known to {:.1f} %", percent * mean(uncertainties));
    return text + ".</li>\n";
}

std::string fact(const char *name, const std::string &text) {
    return fmt::format("<dt>{}</dt><dd>{}</dd>\n", name, escaped(text));
}

} // namespace

std::string head(const ReportData &data) {
    std::string html = "<header>\n<h1>Livermark report</h1>\n<p class=\"lead\">How far mass-spring models are from a "
                       "finite element reference, what they cost, and how long a time step they bear.</p>\n<ul>\n";
    const auto labels = body_labels(data.results);
    for (const auto &label : labels)
        html += finding(data, label);
    html += "</ul>\n<dl class=\"facts\">\n";
    html +=
        fact("Files", fmt::format("{} of runs, {} of stability, {} of histories, {} of timings", data.results.size(),
                                  data.stability.size(), data.histories.size(), data.timings.size()));
    if (!data.results.empty()) {
        const auto newest = std::ranges::max_element(
            data.results, {}, [](const results::Result &result) { return result.provenance.created; });
        html += fact("Bodies", fmt::format("{}", fmt::join(labels, "; ")));
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
