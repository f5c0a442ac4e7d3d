#include "studies/advise/advise.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "core/mesh/plausible_liver.hpp"
#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/tool/tool_stiffness.hpp"
#include "core/units.hpp"
#include "msm/dynamics/time_step.hpp"
#include "results/one_reference.hpp"
#include "studies/models/model_table.hpp"

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

/// Errors at the tool, of radii within the smallest factor that leaves every model enough load cases, or of all.
std::vector<KnownError> errors_of_alike_tools(const std::vector<KnownError> &known, double radius) {
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
        if (std::ranges::all_of(most, [&](const auto &all_of_model) {
                return counts[all_of_model.first] >= std::min(fewest_cases, all_of_model.second);
            }))
            break;
    }
    return chosen;
}

void add_tool_errors(const std::vector<KnownError> &known, double radius, std::map<std::string, ExpectedError> &models,
                     Evidence &evidence) {
    const auto chosen = errors_of_alike_tools(known, radius);
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

using core::millimetres;
using core::milliseconds;
using core::percent;

/// Below this many edges in its radius a mesh does not follow a tool (docs/studies/at_the_tool.md, "The radius of the
/// tool").
constexpr double fewest_edges_in_radius = 2.0;
/// A lump of fewer edges across has its stiffness from a few tetrahedra.
constexpr double fewest_edges_across = 3.0;
/// From here on the volume is a hundred times as stiff as the shape, lambda over mu.
constexpr double nearly_incompressible = 0.49;
constexpr double much_of_a_body = 0.05;
/// A step that stiff parts shorten by less is no caveat.
constexpr double little_shorter = 1.3;

using Caveats = std::vector<Caveat>;

void about_tool(const Advice &advice, Caveats &caveats) {
    const double edges = advice.body.tool_radius_in_edges();
    if (edges >= fewest_edges_in_radius)
        return;
    const double wanted = advice.body.tool_radius / fewest_edges_in_radius;
    const double count = advice.body.mesh.num_tetrahedra * std::pow(fewest_edges_in_radius / edges, 3.0);
    caveats.push_back(
        {"tool", 2.0 * fewest_edges_in_radius / edges,
         fmt::format(
             "A tool of {:.3g} mm radius has {:.1f} edges of this surface in its radius, and a mesh needs {:g} or "
             "more. That takes edges of {:.2g} mm where the tool presses; with them everywhere the mesh has about "
             "{:.0f} thousand tetrahedra.",
             millimetres * advice.body.tool_radius, edges, fewest_edges_in_radius, millimetres * wanted,
             std::ceil(count / 1000.0))});
}

/// Values of linear tetrahedra, in words; empty where they are not known.
std::string linear_words(const Advice &advice) {
    if (!advice.linear_tetrahedra || std::isnan(advice.linear_tetrahedra->at_tool))
        return {};
    return fmt::format("Linear tetrahedra lock at {:g}: they are {:.0f} % too stiff under such a tool.",
                       advice.evidence.poisson_ratio, percent * advice.linear_tetrahedra->at_tool);
}

void about_poisson_ratio(const Advice &advice, Caveats &caveats) {
    const auto &evidence = advice.evidence;
    const double ratio = advice.body.material().poisson_ratio;
    const double tolerance = 0.005;
    if (ratio > nearly_incompressible || ratio > evidence.largest_poisson_ratio + tolerance)
        caveats.push_back({"poisson_ratio", 6.0,
                           fmt::format("Poisson's ratio is {:g}, and errors are known up to {:g}: expect larger ones, "
                                       "shorter steps, and forces that are too large at the end of a press. {}",
                                       ratio, evidence.largest_poisson_ratio, linear_words(advice))});
    else if (ratio < evidence.least_poisson_ratio - tolerance)
        caveats.push_back({"poisson_ratio", 2.5,
                           fmt::format("Poisson's ratio is {:g}, and errors are known from {:g} on: below it models "
                                       "differ less, and springs without a volume term are right at 1/4 alone.",
                                       ratio, evidence.least_poisson_ratio)});
    else if (advice.linear_tetrahedra && advice.linear_tetrahedra->at_tool > core::smallest_felt_difference)
        caveats.push_back(
            {"poisson_ratio", 1.5, fmt::format("Poisson's ratio is {:g}. {}", ratio, linear_words(advice))});
}

void about_lesions(const Advice &advice, Caveats &caveats) {
    const RegionFigures *worst = nullptr;
    for (std::size_t r = 0; r < advice.body.regions.size(); ++r)
        if (const auto &region = advice.body.regions[r];
            r != advice.body.main_region && region.smallest_part_in_edges < fewest_edges_across &&
            (!worst || region.smallest_part_in_edges < worst->smallest_part_in_edges))
            worst = &region;
    if (worst)
        caveats.push_back(
            {"lesions", 2.0 * fewest_edges_across / worst->smallest_part_in_edges,
             fmt::format("The smallest part of region '{}' has {} tetrahedra and is {:.1f} edges across; below {:g} "
                         "the mesh determines its stiffness. Mesh it finer, or expect errors above and beside it.",
                         worst->name, worst->smallest_part_tetrahedra, worst->smallest_part_in_edges,
                         fewest_edges_across)});
}

void about_stiff_parts(const core::Body &body, const Advice &advice, double scaled, Caveats &caveats) {
    const auto &first = advice.touch.empty() ? advice.position.front() : advice.touch.front();
    const double longer = scaled / first.cost.critical_time_step;
    if (longer < little_shorter || msm::stiff_parts(body).empty())
        return;
    caveats.push_back(
        {"stiff_parts", 1.0 + longer,
         fmt::format(
             "Stiff regions shorten the critical step of {} to {:.3g} ms. Selective mass scaling makes it {:.3g} ms, "
             "{:.1f} times as long, and does not change equilibria (`livermark stability --mass-scaling`).",
             first.error.model, milliseconds * first.cost.critical_time_step, milliseconds * scaled, longer)});
}

void about_thin_parts(const Advice &advice, Caveats &caveats) {
    if (advice.body.thin_part > much_of_a_body)
        caveats.push_back({"thin_parts", 2.0 + 10.0 * advice.body.thin_part,
                           fmt::format("{:.0f} % of the volume is one layer of tetrahedra thick (all corners on the "
                                       "surface). Such parts bend too stiffly; errors were not observed on them.",
                                       percent * advice.body.thin_part)});
}

void about_short_edges(const Advice &advice, Caveats &caveats) {
    const auto &mesh = advice.body.mesh;
    const double part = mesh.shortest_edge / mesh.mean_edge, usual = 0.2;
    if (part < usual)
        caveats.push_back(
            {"short_edges", 1.0 + usual / part,
             fmt::format("The shortest edge is {:.2g} mm, {:.2f} of the mean, and the smallest quality of "
                         "a tetrahedron {:.2f}: a few such tetrahedra set the step of all nodes. Remesh "
                         "there.",
                         millimetres * mesh.shortest_edge, part, mesh.smallest_quality)});
}

void about_likeness(const core::Body &body, const Advice &advice, Caveats &caveats) {
    const auto &evidence = advice.evidence;
    if (!core::doubts_about_liver(body.mesh).empty())
        caveats.push_back({"not_a_liver", 3.0,
                           fmt::format("Errors were observed on livers of adults; this body of {:.3g} L is not one. "
                                       "Run `livermark run` on it before you rely on the ranking.",
                                       1e3 * advice.body.mesh.volume)});
    const double ratio = static_cast<double>(advice.body.mesh.num_tetrahedra) / evidence.tetrahedra;
    if (const double octaves = std::abs(std::log2(ratio)); octaves > 1.0)
        caveats.push_back(
            {"tetrahedra", octaves,
             fmt::format("Errors of the displacement were observed on about {} tetrahedra, and this body "
                         "has {}: expect {} ones.",
                         evidence.tetrahedra, advice.body.mesh.num_tetrahedra, ratio > 1.0 ? "smaller" : "larger")});
}

void about_material(const AdviceOptions &options, const Advice &advice, Caveats &caveats) {
    if (options.is_material_assumed)
        caveats.push_back(
            {"material", 3.5,
             fmt::format(
                 "The material of this body is not given; {:g} Pa and Poisson's ratio {:g} are assumed. Forces are "
                 "proportional to Young's modulus, and steps to one over its square root (--young, or a body .toml).",
                 advice.body.material().young_modulus, advice.body.material().poisson_ratio)});
}

/// Caveats of every body, where nothing worse is.
void about_errors(const Advice &advice, Caveats &caveats) {
    const auto &first = advice.touch.empty() ? advice.position.front().error : advice.touch.front().error;
    if (std::isnan(first.large_at_tool))
        caveats.push_back(
            {"large_deformations", 2.0,
             fmt::format("Nothing is known of {} under loads of surgical size; run `livermark run --regime "
                         "large` on this body.",
                         first.model)});
    if (const auto *mixed = advice.evidence.find(models::static_reference(core::Regime::small).on_mesh))
        caveats.push_back(
            {"reference", 1.0,
             fmt::format("Quadratic elements with a pressure on such meshes are {:.1f} % off at the tool and {:.1f} % "
                         "in L2 themselves: smaller differences between models mean nothing.",
                         percent * mixed->at_tool, percent * mixed->relative_l2)});
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

std::vector<Caveat> find_caveats(const core::Body &body, const AdviceOptions &options, const Advice &advice,
                                 double scaled_time_step) {
    Caveats caveats;
    about_tool(advice, caveats);
    about_poisson_ratio(advice, caveats);
    about_lesions(advice, caveats);
    about_stiff_parts(body, advice, scaled_time_step, caveats);
    about_thin_parts(advice, caveats);
    about_short_edges(advice, caveats);
    about_likeness(body, advice, caveats);
    about_material(options, advice, caveats);
    about_errors(advice, caveats);
    std::ranges::stable_sort(caveats, std::ranges::greater(), &Caveat::weight);
    return caveats;
}

} // namespace livermark::studies
