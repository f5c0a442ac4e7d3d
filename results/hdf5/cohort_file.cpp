#include "results/hdf5/cohort_file.hpp"

#include <algorithm>
#include <cstdint>
#include <fmt/format.h>
#include <utility>

#include "results/hdf5/file_parts.hpp"
#include "support/whole_file.hpp"

namespace livermark::results {

namespace {

using hdf5::InputFile;
using hdf5::OutputFile;

const std::vector<std::string> halves{"training", "unseen"};
const std::vector<std::string> regimes{core::to_string(core::Regime::small), core::to_string(core::Regime::large)};
const std::vector<std::string> statuses{core::to_string(core::SolutionStatus::ok),
                                        core::to_string(core::SolutionStatus::diverged),
                                        core::to_string(core::SolutionStatus::not_converged)};

/// A column of words, which a file has as numbers into a list of names.
class Words {
  public:
    Words() = default;
    explicit Words(std::vector<std::string> names) : names_(std::move(names)) {}

    void add(const std::string &word) {
        const auto found = std::ranges::find(names_, word);
        rows_.push_back(static_cast<int>(found - names_.begin()));
        if (found == names_.end())
            names_.push_back(word);
    }
    void write(OutputFile &file, const std::string &path) const {
        file.dataset(path, rows_, "");
        file.texts(path, "names", names_);
    }

  private:
    std::vector<std::string> names_;
    std::vector<int> rows_;
};

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

void write_bodies(OutputFile &file, const std::vector<CohortBody> &bodies) {
    std::vector<std::string> names;
    std::vector<int> number, num_lesions, lesion_body;
    std::vector<double> volume, surface, left_part, front_to_back;
    std::vector<std::uint8_t> has_riedel_lobe;
    std::vector<core::Vector3> center, semi_axes;
    for (const auto &body : bodies) {
        for (const auto &lesion : body.lesions) {
            lesion_body.push_back(static_cast<int>(names.size()));
            center.push_back(lesion.center);
            semi_axes.push_back(lesion.semi_axes);
        }
        names.push_back(body.name);
        number.push_back(body.number);
        volume.push_back(body.volume);
        surface.push_back(body.body_surface);
        left_part.push_back(body.left_part);
        front_to_back.push_back(body.front_to_back);
        has_riedel_lobe.push_back(body.has_riedel_lobe ? 1 : 0);
        num_lesions.push_back(static_cast<int>(body.lesions.size()));
    }
    file.group("/bodies");
    file.texts("/bodies", "names", names);
    file.dataset("/bodies/number", number, "");
    file.dataset("/bodies/volume", volume, "m^3");
    file.dataset("/bodies/body_surface", surface, "m^2");
    file.dataset("/bodies/left_part", left_part, "");
    file.dataset("/bodies/front_to_back", front_to_back, "");
    file.dataset("/bodies/has_riedel_lobe", has_riedel_lobe, "");
    file.dataset("/bodies/num_lesions", num_lesions, "");
    file.group("/lesions");
    file.dataset("/lesions/body", lesion_body, "");
    file.dataset("/lesions/center", center, "m");
    file.dataset("/lesions/semi_axes", semi_axes, "m");
}

void write_errors(OutputFile &file, const std::vector<CohortBody> &bodies, const std::vector<CohortError> &errors) {
    std::vector<std::string> names;
    for (const auto &body : bodies)
        names.push_back(body.name);
    Words body(names), load_case, model, regime(regimes), status(statuses);
    std::vector<double> ratio, relative_l2, reaction_error;
    for (const auto &error : errors) {
        body.add(error.body);
        load_case.add(error.load_case);
        model.add(error.model);
        regime.add(core::to_string(error.regime));
        status.add(core::to_string(error.status));
        ratio.push_back(error.poisson_ratio);
        relative_l2.push_back(error.relative_l2);
        reaction_error.push_back(error.reaction_error);
    }
    file.group("/errors");
    body.write(file, "/errors/body");
    load_case.write(file, "/errors/load_case");
    model.write(file, "/errors/model");
    regime.write(file, "/errors/regime");
    status.write(file, "/errors/status");
    file.dataset("/errors/poisson_ratio", ratio, "");
    file.dataset("/errors/relative_l2", relative_l2, "");
    file.dataset("/errors/reaction_error", reaction_error, "");
}

void write_statistics(OutputFile &file, const std::vector<CohortStatistics> &statistics) {
    Words half(halves), regime(regimes), model;
    std::vector<int> bodies, left_out;
    std::vector<double> ratio, median, median_low, median_high, percentile, percentile_low, percentile_high, worst;
    for (const auto &group : statistics) {
        half.add(group.half);
        regime.add(core::to_string(group.regime));
        model.add(group.model);
        ratio.push_back(group.poisson_ratio);
        bodies.push_back(static_cast<int>(group.means.size()));
        left_out.push_back(group.left_out);
        median.push_back(group.median);
        median_low.push_back(group.median_interval.low);
        median_high.push_back(group.median_interval.high);
        percentile.push_back(group.percentile_95);
        percentile_low.push_back(group.percentile_95_interval.low);
        percentile_high.push_back(group.percentile_95_interval.high);
        worst.push_back(group.worst);
    }
    file.group("/statistics");
    half.write(file, "/statistics/half");
    regime.write(file, "/statistics/regime");
    model.write(file, "/statistics/model");
    file.dataset("/statistics/poisson_ratio", ratio, "");
    file.dataset("/statistics/bodies", bodies, "");
    file.dataset("/statistics/left_out", left_out, "");
    file.dataset("/statistics/median", median, "");
    file.dataset("/statistics/median_low", median_low, "");
    file.dataset("/statistics/median_high", median_high, "");
    file.dataset("/statistics/percentile_95", percentile, "");
    file.dataset("/statistics/percentile_95_low", percentile_low, "");
    file.dataset("/statistics/percentile_95_high", percentile_high, "");
    file.dataset("/statistics/worst", worst, "");
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
    const auto ratio = file.dataset<double>("/errors/poisson_ratio", num);
    const auto body = read_words(file, "/errors/body", num, file.texts("/bodies", "names"));
    const auto load_case = read_words(file, "/errors/load_case", num);
    const auto model = read_words(file, "/errors/model", num);
    const auto regime = read_values<core::Regime>(file, "/errors/regime", num, regimes);
    const auto status = read_values<core::SolutionStatus>(file, "/errors/status", num, statuses);
    std::vector<CohortError> errors;
    for (std::size_t e = 0; e < num; ++e)
        errors.push_back(
            {body[e], regime[e], ratio[e], load_case[e], model[e], status[e], relative_l2[e], reaction_error[e]});
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

Cohort read_cohort(const std::filesystem::path &path) {
    const InputFile file(path, "livermark cohort");
    hdf5::check_schema(file);
    return {.provenance = hdf5::read_provenance(file),
            .tetrahedra = static_cast<int>(file.integer("/", "tetrahedra")),
            .bodies = read_bodies(file),
            .errors = read_errors(file),
            .failures = read_failures(file)};
}

} // namespace livermark::results
