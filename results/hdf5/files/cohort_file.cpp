#include "results/hdf5/files/cohort_file.hpp"

#include <algorithm>
#include <cstdint>
#include <fmt/format.h>
#include <functional>
#include <limits>
#include <utility>

#include "results/hdf5/file_parts.hpp"
#include "results/hdf5/io/read_apart.hpp"
#include "support/whole_file.hpp"

namespace livermark::results {

namespace {

using hdf5::InputFile;
using hdf5::OutputFile;
using hdf5::write_column;

const std::vector<std::string> halves{"training", "unseen"};
const std::vector<std::string> regimes{core::to_string(core::Regime::small), core::to_string(core::Regime::large)};
const std::vector<std::string> statuses{core::to_string(core::SolutionStatus::ok),
                                        core::to_string(core::SolutionStatus::diverged),
                                        core::to_string(core::SolutionStatus::not_converged)};

/// A column of words, which a file has as numbers into a list of names.
/// @param word   a member of the row, or a function of it
/// @param names  those that stand first in the list
template <class Row, class Word>
void write_words(OutputFile &file, const std::string &path, const std::vector<Row> &rows, Word word,
                 std::vector<std::string> names = {}) {
    std::vector<int> numbers;
    for (const auto &row : rows) {
        const std::string name = std::invoke(word, row);
        const auto found = std::ranges::find(names, name);
        numbers.push_back(static_cast<int>(found - names.begin()));
        if (found == names.end())
            names.push_back(name);
    }
    file.dataset(path, numbers, "");
    file.texts(path, "names", names);
}

/// @return the words of a column, a number for each row
std::vector<std::string> read_words(const InputFile &file, const std::string &path, std::size_t num_rows,
                                    const std::vector<std::string> &names) {
    std::vector<std::string> words;
    for (const int number : file.dataset<int>(path, num_rows)) {
        if (number < 0 || number >= std::ssize(names))
            file.refuse(path, fmt::format("row {} is {}, and there are {} names", words.size(), number, names.size()));
        words.push_back(names[number]);
    }
    return words;
}

std::vector<std::string> read_words(const InputFile &file, const std::string &path, std::size_t num_rows) {
    return read_words(file, path, num_rows, file.texts(path, "names"));
}

/// @param known  in the order of the values of the enumeration
template <class Value>
std::vector<Value> read_values(const InputFile &file, const std::string &path, std::size_t num_rows,
                               const std::vector<std::string> &known) {
    std::vector<Value> values;
    for (const auto &word : read_words(file, path, num_rows)) {
        const auto found = std::ranges::find(known, word);
        if (found == known.end())
            file.refuse(path, fmt::format("has the name '{}', which is none of {}", word, fmt::join(known, ", ")));
        values.push_back(static_cast<Value>(found - known.begin()));
    }
    return values;
}

std::vector<std::string> names_of(const std::vector<CohortBody> &bodies) {
    std::vector<std::string> names;
    for (const auto &body : bodies)
        names.push_back(body.name);
    return names;
}

void write_bodies(OutputFile &file, const std::vector<CohortBody> &bodies) {
    std::vector<int> lesion_body;
    std::vector<CohortLesion> lesions;
    for (std::size_t b = 0; b < bodies.size(); ++b) {
        lesion_body.insert(lesion_body.end(), bodies[b].lesions.size(), static_cast<int>(b));
        lesions.insert(lesions.end(), bodies[b].lesions.begin(), bodies[b].lesions.end());
    }
    file.group("/bodies");
    file.texts("/bodies", "names", names_of(bodies));
    write_column(file, "/bodies/number", bodies, &CohortBody::number);
    write_column(file, "/bodies/volume", bodies, &CohortBody::volume, "m^3");
    write_column(file, "/bodies/body_surface", bodies, &CohortBody::body_surface, "m^2");
    write_column(file, "/bodies/left_part", bodies, &CohortBody::left_part);
    write_column(file, "/bodies/front_to_back", bodies, &CohortBody::front_to_back);
    write_column(file, "/bodies/has_riedel_lobe", bodies,
                 [](const CohortBody &body) { return std::uint8_t{body.has_riedel_lobe}; });
    write_column(file, "/bodies/num_lesions", bodies,
                 [](const CohortBody &body) { return static_cast<int>(body.lesions.size()); });
    file.group("/lesions");
    file.dataset("/lesions/body", lesion_body, "");
    write_column(file, "/lesions/center", lesions, &CohortLesion::center, "m");
    write_column(file, "/lesions/semi_axes", lesions, &CohortLesion::semi_axes, "m");
}

void write_errors(OutputFile &file, const std::vector<CohortBody> &bodies, const std::vector<CohortError> &errors) {
    file.group("/errors");
    write_words(file, "/errors/body", errors, &CohortError::body, names_of(bodies));
    write_words(file, "/errors/load_case", errors, &CohortError::load_case);
    write_words(file, "/errors/model", errors, &CohortError::model);
    write_words(
        file, "/errors/regime", errors, [](const CohortError &error) { return core::to_string(error.regime); },
        regimes);
    write_words(
        file, "/errors/status", errors, [](const CohortError &error) { return core::to_string(error.status); },
        statuses);
    write_words(file, "/errors/reference", errors, &CohortError::reference);
    write_column(file, "/errors/poisson_ratio", errors, &CohortError::poisson_ratio);
    write_column(file, "/errors/relative_l2", errors, &CohortError::relative_l2);
    write_column(file, "/errors/reaction_error", errors, &CohortError::reaction_error);
    write_column(file, "/errors/stiffness_at_tool", errors, &CohortError::stiffness);
    write_column(file, "/errors/tool_radius_in_edges", errors, &CohortError::tool_radius_in_edges);
}

void write_statistics(OutputFile &file, const std::vector<CohortStatistics> &statistics) {
    using Group = CohortStatistics;
    file.group("/statistics");
    write_words(file, "/statistics/half", statistics, &Group::half, halves);
    write_words(
        file, "/statistics/regime", statistics, [](const Group &group) { return core::to_string(group.regime); },
        regimes);
    write_words(file, "/statistics/model", statistics, &Group::model);
    write_words(file, "/statistics/reference", statistics, &Group::reference);
    write_column(file, "/statistics/poisson_ratio", statistics, &Group::poisson_ratio);
    write_column(file, "/statistics/bodies", statistics,
                 [](const Group &group) { return static_cast<int>(group.means.size()); });
    write_column(file, "/statistics/left_out", statistics, &Group::left_out);
    const auto write_quantile = [&](const std::string &name, double Group::*value, Interval Group::*interval) {
        const auto path = "/statistics/" + name;
        write_column(file, path, statistics, value);
        write_column(file, path + "_low", statistics, [=](const Group &group) { return (group.*interval).low; });
        write_column(file, path + "_high", statistics, [=](const Group &group) { return (group.*interval).high; });
    };
    write_quantile("median", &Group::median, &Group::median_interval);
    write_quantile("percentile_95", &Group::percentile_95, &Group::percentile_95_interval);
    write_column(file, "/statistics/worst", statistics, &Group::worst);
    write_quantile("stiffness_median", &Group::stiffness_median, &Group::stiffness_median_interval);
    write_column(file, "/statistics/stiffness_worst", statistics, &Group::stiffness_worst);
}

std::vector<CohortBody> read_bodies(const InputFile &file) {
    const auto names = file.texts("/bodies", "names");
    const auto column = [&](const char *name) {
        return file.dataset<double>(fmt::format("/bodies/{}", name), names.size());
    };
    const auto number = file.dataset<int>("/bodies/number", names.size());
    const auto volume = column("volume"), surface = column("body_surface"), left_part = column("left_part"),
               front_to_back = column("front_to_back");
    const auto has_riedel_lobe = file.dataset<std::uint8_t>("/bodies/has_riedel_lobe", names.size());
    std::vector<CohortBody> bodies;
    for (std::size_t b = 0; b < names.size(); ++b)
        bodies.push_back(
            {number[b], names[b], volume[b], surface[b], left_part[b], front_to_back[b], has_riedel_lobe[b] != 0, {}});
    const auto center = file.dataset<core::Vector3>("/lesions/center");
    const auto semi_axes = file.dataset<core::Vector3>("/lesions/semi_axes", center.size());
    const auto body = file.dataset<int>("/lesions/body", center.size());
    for (std::size_t l = 0; l < center.size(); ++l) {
        if (body[l] < 0 || body[l] >= std::ssize(bodies))
            file.refuse("/lesions/body",
                        fmt::format("row {} is {}, and there are {} bodies", l, body[l], names.size()));
        bodies[body[l]].lesions.push_back({center[l], semi_axes[l]});
    }
    return bodies;
}

std::vector<CohortError> read_errors(const InputFile &file) {
    const auto relative_l2 = file.dataset<double>("/errors/relative_l2");
    const auto num = relative_l2.size();
    const auto reaction_error = file.dataset<double>("/errors/reaction_error", num);
    const auto later_column = [&](const char *path) { // files of earlier versions have none
        return file.has(path) ? file.dataset<double>(path, num)
                              : std::vector<double>(num, std::numeric_limits<double>::quiet_NaN());
    };
    const auto stiffness = later_column("/errors/stiffness_at_tool");
    const auto radius = later_column("/errors/tool_radius_in_edges");
    const auto ratio = file.dataset<double>("/errors/poisson_ratio", num);
    const auto body = read_words(file, "/errors/body", num, file.texts("/bodies", "names"));
    const auto load_case = read_words(file, "/errors/load_case", num);
    const auto model = read_words(file, "/errors/model", num);
    const auto regime = read_values<core::Regime>(file, "/errors/regime", num, regimes);
    const auto status = read_values<core::SolutionStatus>(file, "/errors/status", num, statuses);
    const auto reference =
        file.has("/errors/reference") ? read_words(file, "/errors/reference", num) : std::vector<std::string>(num);
    std::vector<CohortError> errors;
    for (std::size_t e = 0; e < num; ++e)
        errors.push_back({body[e], regime[e], ratio[e], load_case[e], model[e], status[e], relative_l2[e],
                          reaction_error[e], stiffness[e], reference[e], radius[e]});
    return errors;
}

/// One behind the other as UTF-8, each ended by a line feed: an attribute has room for 64 KiB only.
void write_failures(OutputFile &file, const std::vector<std::string> &failures) {
    const auto text = fmt::format("{}\n", fmt::join(failures, "\n"));
    if (!failures.empty())
        file.dataset("/failures", std::vector<std::uint8_t>(text.begin(), text.end()), "");
}

std::vector<std::string> read_failures(const InputFile &file) {
    std::vector<std::string> failures;
    if (!file.has("/failures"))
        return failures;
    std::string line;
    for (const auto byte : file.dataset<std::uint8_t>("/failures"))
        if (byte == '\n')
            failures.push_back(std::exchange(line, {}));
        else
            line += static_cast<char>(byte);
    return failures;
}

} // namespace

void write_cohort(const std::filesystem::path &path, const Cohort &cohort) {
    OutputFile file;
    hdf5::write_provenance(file, cohort.provenance);
    file.integer("/", "tetrahedra", cohort.tetrahedra);
    write_bodies(file, cohort.bodies);
    write_errors(file, cohort.bodies, cohort.errors);
    write_statistics(file, cohort_statistics(cohort.errors));
    write_failures(file, cohort.failures);
    support::write_whole(path, file.image());
}

namespace {

Cohort cohort_in(const std::filesystem::path &path) {
    const InputFile file(path, "livermark cohort");
    hdf5::check_schema(file);
    return {.provenance = hdf5::read_provenance(file),
            .tetrahedra = static_cast<int>(file.integer("/", "tetrahedra")),
            .bodies = read_bodies(file),
            .errors = read_errors(file),
            .failures = read_failures(file)};
}

} // namespace

Cohort read_cohort(const std::filesystem::path &path) {
    return hdf5::read_once_tried(path, [&] { return cohort_in(path); });
}

} // namespace livermark::results
