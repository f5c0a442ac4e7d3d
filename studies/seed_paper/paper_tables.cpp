#include "studies/seed_paper/paper_tables.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <numeric>
#include <optional>

#include "msm/dynamics/damping.hpp"
#include "studies/parameters/body_parameters.hpp"
#include "studies/seed_paper/seed_paper.hpp"

namespace livermark::studies {

namespace {

constexpr const char *paper_law = "lloyd";

/// Livers hold 1.5 L, with a standard deviation of 0.4 L.
bool may_be_a_liver(const core::Body &body) {
    constexpr double smallest = 0.5e-3, largest = 3.0e-3; // [m^3]
    const auto volumes = core::tetrahedron_volumes(body.mesh);
    const double volume = std::accumulate(volumes.begin(), volumes.end(), 0.0);
    return volume > smallest && volume < largest;
}

const core::SpringNetwork *springs_in(const results::Result &result) {
    const auto model = std::ranges::find(result.models, paper_law, &results::ModelResult::name);
    return model != result.models.end() && model->solution.springs ? &*model->solution.springs : nullptr;
}

std::optional<core::RayleighDamping> damping_of(const std::string &body, const ReportData &data) {
    for (const auto &result : data.results)
        if (result.problem.body->name == body && result.problem.load_case.release)
            return result.problem.load_case.release->damping;
    for (const auto &stability : data.stability)
        if (stability.body == body)
            return stability.damping;
    return std::nullopt;
}

PaperTable table_of(const results::Result &result, const core::SpringNetwork &springs, const ReportData &data) {
    const auto &body = *result.problem.body;
    const auto parameters =
        spring_parameters(body, springs, damping_of(body.name, data).value_or(core::RayleighDamping{}));
    PaperTable table{.body = body.name,
                     .rows = {{{"printed"}, {"as"}, {"printed [SI]", true}, {"here [SI]", true}, {"ratio", true}}, {}},
                     .objections = {},
                     .command = result.provenance.command};
    for (const auto &claim : compare_with_paper(parameters)) {
        const auto printed = fmt::format("{} {} {}", claim.quantity->name, claim.printed, claim.quantity->unit.name);
        for (const auto &reading : claim.readings)
            table.rows.rows.push_back({printed, reading.meaning, fmt::format("{:.5g}", reading.printed),
                                       results::significant(reading.computed, 5),
                                       results::significant(reading.ratio(), 5)});
        if (claim.readings.empty()) // no file here says how the body is damped
            table.rows.rows.push_back({printed, "no damping is known of this body here", "-", "-", "-"});
        else if (!claim.objection.empty())
            table.objections.push_back(claim.objection);
    }
    return table;
}

} // namespace

std::vector<PaperTable> paper_tables(const ReportData &data) {
    std::vector<PaperTable> tables;
    for (const auto &result : data.results) {
        const auto &body = *result.problem.body;
        const auto *springs = springs_in(result);
        if (springs && std::ranges::find(tables, body.name, &PaperTable::body) == tables.end() && may_be_a_liver(body))
            tables.push_back(table_of(result, *springs, data));
    }
    return tables;
}

} // namespace livermark::studies
