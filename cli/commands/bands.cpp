#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <system_error>
#include <vector>

#include "cli/commands/commands.hpp"
#include "meshes/io/body_reader.hpp"
#include "results/error_bands.hpp"
#include "results/hdf5/result_files.hpp"
#include "results/tables/studies/band_proposals.hpp"
#include "studies/catalogue.hpp"
#include "support/input_error.hpp"
#include "support/known_names.hpp"
#include "support/root_folder.hpp"

namespace livermark::cli {

namespace {

struct BandsOptions {
    std::vector<std::string> paths;
    std::vector<std::string> models;
    bool all = false;
};

void refuse_unknown_models(const std::vector<std::string> &wanted, const std::vector<results::Result> &results) {
    std::set<std::string> names;
    for (const auto &result : results)
        for (const auto &model : result.models)
            names.insert(model.name);
    for (const auto &name : wanted)
        if (!names.contains(name))
            throw support::InputError(support::unknown_name("model", name, {names.begin(), names.end()}));
}

bool same_materials(const std::vector<core::Material> &a, const std::vector<core::Material> &b) {
    return std::ranges::equal(a, b, [](const core::Material &one, const core::Material &other) {
        return one.density == other.density && one.young_modulus == other.young_modulus &&
               one.poisson_ratio == other.poisson_ratio;
    });
}

/// Takes results out whose body ships with other materials: a run with --young or --poisson looks at no band.
void leave_out_other_materials(std::vector<results::Result> &results) {
    std::map<std::string, std::vector<core::Material>> shipped;
    std::erase_if(results, [&](const results::Result &result) {
        const auto &body = *result.problem.body;
        const auto file = support::root_folder() / studies::bodies_folder / (body.name + ".toml");
        if (std::error_code ignored; !std::filesystem::exists(file, ignored))
            return false; // a body of the user
        if (!shipped.contains(body.name))
            shipped[body.name] = meshes::read_body(file).materials;
        const bool is_other = !same_materials(body.materials, shipped[body.name]);
        if (is_other)
            fmt::print(
                stderr,
                "livermark: skipped: {} under {}: the body ships with other materials, for which its bands hold\n",
                body.name, result.problem.load_case.name);
        return is_other;
    });
}

/// What somebody has to know who pastes the lines: to standard error.
void print_remarks(const results::BandProposals &found, const results::ErrorBands &present) {
    for (const auto &sentence : found.passed_over)
        fmt::print(stderr, "livermark: passed over: {}\n", sentence);
    std::size_t num_new = 0, num_changed = 0;
    bool is_dirty = false;
    for (const auto &proposal : found.proposals) {
        is_dirty = is_dirty || (proposal.is_due() && proposal.band.origin.find("-dirty,") != std::string::npos);
        if (!proposal.present)
            ++num_new;
        else if (proposal.is_due()) {
            ++num_changed;
            fmt::print(stderr, "{}: {} under {}: {} had {:.2f} +- {:.2f} % and now has {:.2f} %; remove the old line\n",
                       present.places.at(proposal.key), proposal.key[0], proposal.key[1], proposal.key[2],
                       100.0 * proposal.present->expected, 100.0 * proposal.present->margin,
                       100.0 * proposal.relative_l2);
        }
    }
    if (is_dirty)
        fmt::print(stderr, "livermark: the results are of a tree that was modified (-dirty); commit and run again, so "
                           "that the origin can be found\n");
    fmt::print(stderr, "{} of these errors are new, {} have left their bands, {} are in their bands\n", num_new,
               num_changed, found.proposals.size() - num_new - num_changed);
}

int propose(const BandsOptions &options) {
    const auto present = results::read_error_bands(support::root_folder() / "results" / "error_bands.toml");
    auto results =
        results::read_results(std::vector<std::filesystem::path>(options.paths.begin(), options.paths.end()));
    refuse_unknown_models(options.models, results);
    leave_out_other_materials(results);
    const auto found = results::propose_bands(results, options.models, present);
    fmt::print("{}", results::to_toml(results::proposed_bands(found.proposals, options.all)));
    print_remarks(found, present);
    return 0;
}

} // namespace

Command add_bands(CLI::App &parent) {
    auto *command = parent.add_subcommand(
        "bands", "Propose lines for results/error_bands.toml from result files, for entries that are new or outside "
                 "their band; lines go to standard output, remarks to standard error");
    auto options = std::make_shared<BandsOptions>();
    options->paths = {(support::root_folder() / "results" / "runs").string()};
    command->add_option("paths", options->paths, "Result files of 'livermark run', or folders of them")
        ->capture_default_str();
    command->add_option("--model", options->models, "Models; by default all in the files");
    command->add_flag("--all", options->all, "Also propose lines for entries inside their bands");
    return [options] { return propose(*options); };
}

} // namespace livermark::cli
