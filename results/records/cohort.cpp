#include "results/records/cohort.hpp"

#include <algorithm>
#include <cstdint>
#include <fmt/format.h>
#include <limits>

#include "core/tool/tool_stiffness.hpp"
#include "results/hdf5/record_file.hpp"
#include "results/one_reference.hpp"

namespace livermark::results {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

bool is_in_cohort(const Result &result) {
    return is_plain_static(result) && !leaves_regime(result) && !ends_at_rest(result) &&
           cohort_half(result.problem.body->name).has_value();
}

} // namespace

std::optional<std::string> cohort_half(const std::string &body) {
    if (body.empty() || body.back() < '0' || body.back() > '9')
        return std::nullopt;
    return (body.back() - '0') % 2 == 1 ? "training" : "unseen";
}

std::vector<CohortError> cohort_errors(std::span<const Result> results) {
    std::vector<CohortError> errors;
    for (const auto &result : results) {
        if (!is_in_cohort(result))
            continue;
        const auto &problem = result.problem;
        const double radius =
            core::radius_in_edges(core::tool_places(problem.body->mesh, problem.load_case)).value_or(nan);
        const auto &known = result.reference_uncertainty;
        const bool has_bar = known && known->reference == reference_of(result);
        for (const auto &model : result.models)
            if (model.comparison || model.solution.status != core::SolutionStatus::ok)
                errors.push_back({.body = problem.body->name,
                                  .regime = problem.load_case.regime,
                                  .poisson_ratio = poisson_ratio(result),
                                  .load_case = problem.load_case.name,
                                  .model = model.name,
                                  .status = model.solution.status,
                                  .relative_l2 = model.comparison ? model.comparison->relative_l2 : nan,
                                  .reaction_error = model.comparison ? model.comparison->reaction_error : nan,
                                  .stiffness = model.comparison && model.comparison->tool
                                                   ? model.comparison->tool->worst_stiffness()
                                                   : nan,
                                  .reference = reference_of(result),
                                  .tool_radius_in_edges = radius,
                                  .uncertainty = has_bar ? known->relative_l2 : nan,
                                  .stiffness_uncertainty = has_bar ? known->stiffness.value_or(nan) : nan});
    }
    return errors;
}

namespace {

using hdf5::Of;

std::vector<std::string> names_of(const std::vector<CohortBody> &bodies) {
    std::vector<std::string> names;
    for (const auto &body : bodies)
        names.push_back(body.name);
    return names;
}

/// An ellipsoid, and the index of the body that it is in.
struct PlacedLesion : CohortLesion {
    int body = 0;
};

std::vector<PlacedLesion> lesions_of(const std::vector<CohortBody> &bodies) {
    std::vector<PlacedLesion> lesions;
    for (std::size_t b = 0; b < bodies.size(); ++b)
        for (const auto &lesion : bodies[b].lesions)
            lesions.push_back({lesion, static_cast<int>(b)});
    return lesions;
}

template <class At> void describe_bodies(At at, Of<At, std::vector<CohortBody>> &bodies) {
    auto columns = hdf5::columns_of(at, bodies);
    columns.texts("names", &CohortBody::name);
    columns.column("number", &CohortBody::number);
    columns.column("volume", &CohortBody::volume, "m^3");
    columns.column("body_surface", &CohortBody::body_surface, "m^2");
    columns.column("left_part", &CohortBody::left_part);
    columns.column("front_to_back", &CohortBody::front_to_back);
    columns.column("has_riedel_lobe", &CohortBody::has_riedel_lobe);
    if constexpr (!At::reads)
        columns.column("num_lesions", [](auto &body) { return static_cast<int>(body.lesions.size()); });
}

template <class At> void describe_lesions(At at, Of<At, std::vector<CohortBody>> &bodies) {
    auto lesions = lesions_of(bodies);
    auto columns = hdf5::columns_of(at, lesions);
    columns.column("body", &PlacedLesion::body);
    columns.column("center", &PlacedLesion::center, "m");
    columns.column("semi_axes", &PlacedLesion::semi_axes, "m");
    if constexpr (At::reads)
        for (const auto &lesion : lesions) {
            at.check(lesion.body >= 0 && lesion.body < std::ssize(bodies), "body",
                     fmt::format("has {}, and there are {} bodies", lesion.body, bodies.size()));
            bodies[static_cast<std::size_t>(lesion.body)].lesions.push_back(lesion);
        }
}

template <class At>
void describe_errors(At at, const std::vector<CohortBody> &bodies, Of<At, std::vector<CohortError>> &errors) {
    auto columns = hdf5::columns_of(at, errors);
    columns.numbered_words("body", &CohortError::body, names_of(bodies));
    columns.numbered_words("load_case", &CohortError::load_case);
    columns.numbered_words("model", &CohortError::model);
    columns.numbered_values("regime", &CohortError::regime);
    columns.numbered_values("status", &CohortError::status);
    if (at.has("reference")) // files of earlier versions have none
        columns.numbered_words("reference", &CohortError::reference);
    columns.column("poisson_ratio", &CohortError::poisson_ratio);
    columns.column("relative_l2", &CohortError::relative_l2);
    columns.column("reaction_error", &CohortError::reaction_error);
    if (at.has("stiffness_at_tool")) // nor these four
        columns.column("stiffness_at_tool", &CohortError::stiffness);
    if (at.has("tool_radius_in_edges"))
        columns.column("tool_radius_in_edges", &CohortError::tool_radius_in_edges);
    if (at.has("reference_uncertainty")) {
        columns.column("reference_uncertainty", &CohortError::uncertainty);
        columns.column("stiffness_uncertainty", &CohortError::stiffness_uncertainty);
    }
}

/// One behind the other as UTF-8, each ended by a line feed: an attribute has room for 64 KiB only.
template <class At> void describe_failures(At root, Of<At, std::vector<std::string>> &failures) {
    if (!root.has("failures", !failures.empty()))
        return;
    const auto text = fmt::format("{}\n", fmt::join(failures, "\n"));
    std::vector<std::uint8_t> bytes(text.begin(), text.end());
    root.rows("failures", bytes);
    if constexpr (At::reads)
        for (auto from = bytes.begin(), until = from; (until = std::find(from, bytes.end(), '\n')) != bytes.end();
             from = until + 1)
            failures.emplace_back(from, until);
}

template <class At> void describe_cohort(At root, Of<At, Cohort> &cohort) {
    root.integer("tetrahedra", cohort.tetrahedra);
    describe_bodies(root.group("bodies"), cohort.bodies);
    describe_lesions(root.group("lesions"), cohort.bodies);
    describe_errors(root.group("errors"), cohort.bodies, cohort.errors);
    describe_failures(root, cohort.failures);
}

} // namespace

void write_cohort(const std::filesystem::path &path, const Cohort &cohort) {
    hdf5::write_record(path, cohort, [](auto root, auto &record) { describe_cohort(root, record); });
}

Cohort read_cohort(const std::filesystem::path &path) {
    return hdf5::read_record<Cohort>(path, "livermark cohort",
                                     [](auto root, auto &record) { describe_cohort(root, record); });
}

} // namespace livermark::results
