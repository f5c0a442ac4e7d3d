#include "results/tables/studies/band_proposals.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <set>
#include <utility>

#include "support/input_error.hpp"

namespace livermark::results {

namespace {

double to_four_decimals(double value) {
    return std::round(1e4 * value) / 1e4;
}

std::string origin_of(const Provenance &provenance, const std::string &reference) {
    const auto day = provenance.created.substr(0, provenance.created.find('T'));
    return fmt::format("livermark run, {}, commit {}, against {}", day, provenance.git_commit, reference);
}

/// @return why no band can come from a model; empty if one can
std::string fault_of(const ModelResult &model) {
    if (model.solution.status != core::SolutionStatus::ok)
        return "found no solution: " + model.solution.message;
    if (!model.comparison)
        return "was not compared with the reference";
    return std::isfinite(model.comparison->relative_l2) ? "" : "has an error that is not finite";
}

void add_proposals(BandProposals &result, const Result &from, std::span<const std::string> models,
                   const ErrorBands &present) {
    const auto &body = from.problem.body->name;
    const auto &load_case = from.problem.load_case.name;
    if (!from.reference_uncertainty) {
        result.passed_over.push_back(fmt::format("{} under {}: the uncertainty of its reference is not known; "
                                                 "run it without --reference-on-mesh",
                                                 body, load_case));
        return;
    }
    for (const auto &model : from.models) {
        const bool is_wanted = models.empty() || std::ranges::find(models, model.name) != models.end();
        if (!is_wanted || model.name == from.reference_uncertainty->reference)
            continue;
        if (const auto fault = fault_of(model); !fault.empty()) {
            result.passed_over.push_back(fmt::format("{} under {}: {} {}", body, load_case, model.name, fault));
            continue;
        }
        auto &proposal = result.proposals.emplace_back();
        proposal.key = {body, load_case, model.name};
        proposal.relative_l2 = model.comparison->relative_l2;
        proposal.band.expected = to_four_decimals(proposal.relative_l2);
        proposal.band.margin = proposed_margin;
        proposal.band.origin = origin_of(from.provenance, model.comparison->reference);
        proposal.present = present.find(body, load_case, model.name);
    }
}

} // namespace

BandProposals propose_bands(std::span<const Result> results, std::span<const std::string> models,
                            const ErrorBands &present) {
    BandProposals proposals;
    std::set<std::pair<std::string, std::string>> seen;
    for (const auto &result : results) {
        if (!seen.emplace(result.problem.body->name, result.problem.load_case.name).second)
            throw support::InputError(fmt::format("{} under {} is in two result files; give the folder of one run",
                                                  result.problem.body->name, result.problem.load_case.name));
        add_proposals(proposals, result, models, present);
    }
    std::ranges::sort(proposals.proposals, {}, &BandProposal::key);
    return proposals;
}

std::map<BandKey, ErrorBand> proposed_bands(std::span<const BandProposal> proposals, bool all) {
    std::map<BandKey, ErrorBand> bands;
    for (const auto &proposal : proposals)
        if (all || proposal.is_due())
            bands.emplace(proposal.key, proposal.band);
    return bands;
}

} // namespace livermark::results
