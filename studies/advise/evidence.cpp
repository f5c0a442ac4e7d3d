#include "studies/advise/evidence.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "results/quantile.hpp"
#include "support/input_error.hpp"
#include "support/root_folder.hpp"

namespace livermark::studies {

namespace {

/// Tools whose radius differs by this factor are alike...
constexpr double alike = 1.5;
/// ...unless fewer load cases than these are left for a model; then the factor is squared until there are as many.
constexpr std::size_t fewest_cases = 6;

/// Errors that count: one model, one load case, one body.
struct KnownError {
    std::size_t cohort = 0;
    const results::CohortError *error = nullptr;
};

double distance(double a, double b) {
    return std::abs(std::log(a / b));
}

bool has_failed(const results::CohortError &error) {
    return error.status != core::SolutionStatus::ok;
}

double l2_of(const results::CohortError &error) {
    return has_failed(error) ? std::numeric_limits<double>::infinity() : error.relative_l2;
}

double at_tool_of(const results::CohortError &error) {
    return has_failed(error) ? std::numeric_limits<double>::infinity() : std::abs(error.stiffness);
}

std::vector<KnownError> errors_of_unseen(std::span<const KnownCohort> cohorts, core::Regime regime) {
    std::vector<KnownError> known;
    for (std::size_t c = 0; c < cohorts.size(); ++c)
        for (const auto &error : cohorts[c].cohort.errors)
            if (results::cohort_half(error.body) == "unseen" && error.regime == regime &&
                (has_failed(error) || std::isfinite(error.relative_l2)))
                known.push_back({c, &error});
    return known;
}

bool has_tool(const KnownError &known) {
    return known.error->tool_radius_in_edges > 0.0 && !std::isnan(at_tool_of(*known.error));
}

/// Those at the tool, of radii within the smallest factor that leaves every model enough load cases, or of all.
std::vector<KnownError> of_alike_tools(const std::vector<KnownError> &known, double radius) {
    std::map<std::string, std::size_t> most;
    for (const auto &each : known)
        if (has_tool(each))
            ++most[each.error->model];
    std::vector<KnownError> chosen;
    for (double factor = alike; std::isfinite(factor); factor *= factor) {
        chosen.clear();
        std::map<std::string, std::size_t> counts;
        for (const auto &each : known)
            if (has_tool(each) && distance(each.error->tool_radius_in_edges, radius) <= std::log(factor)) {
                chosen.push_back(each);
                ++counts[each.error->model];
            }
        if (std::ranges::all_of(most, [&](const auto &of_model) {
                return counts[of_model.first] >= std::min(fewest_cases, of_model.second);
            }))
            break;
    }
    return chosen;
}

void add_tool_errors(const std::vector<KnownError> &known, double radius, std::map<std::string, ExpectedError> &models,
                     Evidence &evidence) {
    const auto chosen = of_alike_tools(known, radius);
    std::map<std::string, std::vector<double>> sizes;
    evidence.least_radius = std::numeric_limits<double>::infinity();
    for (const auto &[cohort, error] : chosen) {
        evidence.least_radius = std::min(evidence.least_radius, error->tool_radius_in_edges);
        evidence.largest_radius = std::max(evidence.largest_radius, error->tool_radius_in_edges);
        sizes[error->model].push_back(at_tool_of(*error));
        auto &model = models[error->model];
        if (!has_failed(*error) && !(std::abs(model.worst_at_tool) >= std::abs(error->stiffness))) {
            model.worst_at_tool = error->stiffness;
            model.worst_load_case = error->load_case;
        }
    }
    for (const auto &[name, values] : sizes) {
        models[name].at_tool = results::median(values);
        models[name].num_at_tool = values.size();
    }
}

/// The cohort whose bodies have nearly as many tetrahedra.
std::size_t nearest_cohort(std::span<const KnownCohort> cohorts, const std::vector<KnownError> &known, int tetrahedra) {
    const auto far = [&](const KnownError &each) {
        const int count = cohorts[each.cohort].cohort.tetrahedra;
        return count > 0 ? distance(count, tetrahedra) : std::numeric_limits<double>::max();
    };
    return std::ranges::min_element(known, {}, far)->cohort;
}

void add_displacement_errors(const std::vector<KnownError> &known, std::size_t cohort,
                             std::map<std::string, ExpectedError> &models, Evidence &evidence) {
    std::map<std::string, std::vector<double>> errors;
    std::set<std::string> bodies;
    for (const auto &each : known)
        if (each.cohort == cohort) {
            errors[each.error->model].push_back(l2_of(*each.error));
            models[each.error->model].num_failed += has_failed(*each.error) ? 1 : 0;
            bodies.insert(each.error->body);
            if (!each.error->reference.empty())
                evidence.reference = each.error->reference;
        }
    evidence.num_bodies = bodies.size();
    for (const auto &[name, values] : errors) {
        auto &model = models[name];
        model.relative_l2 = results::median(values);
        model.worst_relative_l2 = *std::ranges::max_element(values);
        model.num_l2 = values.size();
    }
}

double nearest_ratio(const std::vector<KnownError> &known, double ratio) {
    const auto far = [&](const KnownError &each) { return std::abs(each.error->poisson_ratio - ratio); };
    return std::ranges::min_element(known, {}, far)->error->poisson_ratio;
}

void keep_ratio(std::vector<KnownError> &known, double ratio) {
    std::erase_if(known, [&](const auto &each) { return each.error->poisson_ratio != ratio; });
}

void add_large_errors(std::vector<KnownError> known, double ratio, std::map<std::string, ExpectedError> &models,
                      Evidence &evidence) {
    if (known.empty())
        return;
    evidence.large_poisson_ratio = nearest_ratio(known, ratio);
    keep_ratio(known, evidence.large_poisson_ratio);
    for (const auto &each : known)
        if (!each.error->reference.empty())
            evidence.large_reference = each.error->reference;
    std::map<std::string, std::vector<double>> at_tool, displacement;
    for (const auto &each : known) {
        displacement[each.error->model].push_back(l2_of(*each.error));
        models[each.error->model].num_large_failed += has_failed(*each.error) ? 1 : 0;
        if (has_tool(each))
            at_tool[each.error->model].push_back(at_tool_of(*each.error));
    }
    for (const auto &[name, values] : displacement) {
        auto &model = models[name];
        model.large_relative_l2 = results::median(values);
        model.num_large = values.size();
    }
    for (const auto &[name, values] : at_tool)
        models[name].large_at_tool = results::median(values);
}

} // namespace

const ExpectedError *Evidence::find(const std::string &model) const {
    const auto found = std::ranges::find(models, model, &ExpectedError::model);
    return found == models.end() ? nullptr : &*found;
}

std::vector<KnownCohort> shipped_cohorts() {
    const auto folder = support::root_folder() / cohorts_folder;
    std::vector<std::filesystem::path> files;
    std::error_code error;
    for (auto entry = std::filesystem::directory_iterator(folder, error);
         !error && entry != std::filesystem::directory_iterator(); entry.increment(error))
        if (entry->path().extension() == ".h5")
            files.push_back(entry->path());
    if (files.empty())
        throw support::InputError(fmt::format("{}: there are no errors of models here; set LIVERMARK_ROOT to a "
                                              "Livermark source tree, or restore the folder from git",
                                              folder.string()));
    std::ranges::sort(files);
    std::vector<KnownCohort> cohorts;
    for (const auto &file : files)
        cohorts.push_back({fmt::format("{}/{}", cohorts_folder, file.filename().string()), results::read_cohort(file)});
    return cohorts;
}

std::string size_in_words(const char *bodies, int tetrahedra) {
    return tetrahedra > 0 ? fmt::format("{} of about {} tetrahedra", bodies, tetrahedra)
                          : fmt::format("{} of as many tetrahedra as those that ship", bodies);
}

Evidence find_evidence(std::span<const KnownCohort> cohorts, const BodyInQuestion &question) {
    auto known = errors_of_unseen(cohorts, core::Regime::small);
    if (known.empty())
        throw support::InputError("the cohort files have no errors on unseen bodies under small loads; restore "
                                  "results/cohorts from git");
    Evidence evidence;
    const auto [least, largest] =
        std::ranges::minmax(known, {}, [](const KnownError &each) { return each.error->poisson_ratio; });
    evidence.least_poisson_ratio = least.error->poisson_ratio;
    evidence.largest_poisson_ratio = largest.error->poisson_ratio;
    evidence.poisson_ratio = nearest_ratio(known, question.poisson_ratio);
    keep_ratio(known, evidence.poisson_ratio);
    std::map<std::string, ExpectedError> models;
    add_tool_errors(known, question.tool_radius_in_edges, models, evidence);
    const auto nearest = nearest_cohort(cohorts, known, question.tetrahedra);
    evidence.tetrahedra = cohorts[nearest].cohort.tetrahedra;
    add_displacement_errors(known, nearest, models, evidence);
    add_large_errors(errors_of_unseen(cohorts, core::Regime::large), question.poisson_ratio, models, evidence);
    for (auto &[name, model] : models) {
        model.model = name;
        evidence.models.push_back(std::move(model));
    }
    for (const auto &[file, cohort] : cohorts)
        evidence.sources.push_back(
            fmt::format("{}: {} {}, `livermark cohort` of {} at commit {}", file, cohort.bodies.size(),
                        size_in_words(cohort.bodies.size() == 1 ? "liver" : "livers", cohort.tetrahedra),
                        cohort.provenance.created.substr(0, 10), cohort.provenance.git_commit.substr(0, 12)));
    return evidence;
}

Evidence shipped_evidence(const BodyInQuestion &question) {
    return find_evidence(shipped_cohorts(), question);
}

} // namespace livermark::studies
