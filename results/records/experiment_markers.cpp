#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <random>

#include "core/units.hpp"
#include "results/one_reference.hpp"
#include "results/records/experiment.hpp"

namespace livermark::results {

namespace {

constexpr int num_samples = 2000;
constexpr double tail = 0.025; ///< of samples, beyond each end of an interval

/// Squared distances of a run from the measurement, over the markers that are compared and were seen [m^2].
std::vector<double> squared_distances(const ExperimentResult &result, const ExperimentRun &run) {
    std::vector<double> squares;
    const auto &measured = result.states[run.state].displacement;
    for (std::size_t k = 0; k < measured.size(); ++k)
        if (result.is_compared(k) && measured[k].allFinite())
            squares.push_back((run.displacement[k] - measured[k]).squaredNorm());
    return squares;
}

/// Root mean square of samples of squares; the same samples for every list of one length.
std::vector<double> sampled_errors(const std::vector<double> &squares) {
    constexpr std::uint64_t seed = 1979;
    std::mt19937_64 random(seed);
    std::vector<double> errors(num_samples);
    for (auto &error : errors) {
        double sum = 0.0;
        for (std::size_t i = 0; i < squares.size(); ++i)
            sum += squares[random() % squares.size()];
        error = std::sqrt(sum / static_cast<double>(squares.size()));
    }
    return errors;
}

} // namespace

std::string length_cell(double length, int decimals) {
    return std::isfinite(length) ? fixed(core::millimetres * length, decimals) : "-";
}

bool ExperimentResult::has_compared_markers() const {
    return std::ranges::any_of(drives, &std::string::empty);
}

MarkerError marker_error(const ExperimentResult &result, const std::vector<core::Vector3> &displacement,
                         const std::vector<core::Vector3> &measured) {
    core::Vector3 sums = core::Vector3::Zero();
    double largest = 0.0;
    int count = 0;
    for (std::size_t k = 0; k < measured.size(); ++k) {
        if (!result.is_compared(k) || !measured[k].allFinite())
            continue;
        const core::Vector3 squares = (displacement[k] - measured[k]).cwiseAbs2();
        sums += squares;
        largest = std::max(largest, squares.sum());
        ++count;
    }
    const core::Vector3 component = (sums / count).cwiseSqrt();
    const double root_mean_square = component.norm();
    return {root_mean_square,
            std::isfinite(root_mean_square) ? std::sqrt(largest) : root_mean_square,
            {component.begin(), component.end()}};
}

double root_mean_square_distance(const std::vector<core::Vector3> &a, const std::vector<core::Vector3> &b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i)
        sum += (a[i] - b[i]).squaredNorm();
    return std::sqrt(sum / static_cast<double>(a.size()));
}

void compare_with_reference(ExperimentResult &result) {
    std::map<int, const ExperimentRun *> references;
    for (const auto &run : result.runs)
        if (run.model == result.reference)
            references[run.state] = &run;
    std::map<int, std::vector<double>> samples;
    for (auto &run : result.runs) {
        const auto found = references.find(run.state);
        if (found == references.end())
            continue;
        const auto squares = squared_distances(result, run);
        if (squares.size() < 2 || !std::isfinite(run.error) || !std::isfinite(found->second->error))
            continue;
        auto &reference_samples = samples[run.state];
        if (reference_samples.empty())
            reference_samples = sampled_errors(squared_distances(result, *found->second));
        auto differences = sampled_errors(squares);
        for (std::size_t i = 0; i < differences.size(); ++i)
            differences[i] -= reference_samples[i];
        run.beyond_reference = {run.error - found->second->error, quantile(differences, tail),
                                quantile(differences, 1.0 - tail)};
    }
}

Layout marker_table(const ExperimentResult &result) {
    Layout layout{{{"state"},
                   {"model"},
                   {"tetrahedra", true},
                   {"x [mm]", true},
                   {"y [mm]", true},
                   {"z [mm]", true},
                   {"beyond the reference [mm]", true}},
                  {}};
    for (std::size_t s = 0; s < result.states.size(); ++s) {
        std::vector<const ExperimentRun *> runs;
        for (const auto &run : result.runs)
            if (run.state == static_cast<int>(s) && run.status == core::SolutionStatus::ok)
                runs.push_back(&run);
        std::ranges::stable_sort(runs, {}, &ExperimentRun::error);
        for (const auto *run : runs) {
            std::vector<std::string> row{printable(result.states[s].name), run->model, std::to_string(run->tetrahedra)};
            for (const double component : run->component_error)
                row.push_back(length_cell(component));
            const auto &[beyond, low, high] =
                std::array{run->beyond_reference[0], run->beyond_reference[1], run->beyond_reference[2]};
            const auto text = fmt::format("{:+.3f}, {:+.3f} to {:+.3f}", core::millimetres * beyond,
                                          core::millimetres * low, core::millimetres * high);
            row.push_back(!std::isfinite(beyond) || (low == 0.0 && high == 0.0) ? ""
                          : low <= 0.0 && high >= 0.0                           ? fmt::format("({})", text)
                                                                                : text);
            layout.rows.push_back(std::move(row));
        }
    }
    return layout;
}

} // namespace livermark::results
