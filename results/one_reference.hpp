#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include "results/records/result.hpp"

/// References that numbers belong to, and results that may count together, with means and quantiles of numbers. Errors
/// against a reference on refined meshes and against one on the mesh of the models differ by more than many models do
/// (`fem_p2` under traction: 4.2 and 1.4 %), so they are never in one table, as those of the two regimes are not.
namespace livermark::results {

/// NaN of none.
inline double mean(const std::vector<double> &values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// Linear interpolation between the sorted values (type 7 of Hyndman, Fan 1996, The American Statistician 50(4)).
/// @param values  at least one
/// @param part    from 0 to 1
inline double quantile(std::vector<double> values, double part) {
    std::ranges::sort(values);
    const double place = part * static_cast<double>(values.size() - 1);
    const auto below = static_cast<std::size_t>(place);
    const auto above = std::min(below + 1, values.size() - 1);
    return values[below] + (place - static_cast<double>(below)) * (values[above] - values[below]);
}

/// The middle one, or the mean of the two in the middle.
/// @param values  at least one
inline double median(std::vector<double> values) {
    std::ranges::sort(values);
    return 0.5 * (values[(values.size() - 1) / 2] + values[values.size() / 2]);
}

/// The name of the model that the displacements of the others are compared with; empty where nothing was compared.
std::string reference_of(const Result &result);

/// Whether the reference was solved on the mesh of the models and not on refined ones. False where nothing was
/// compared.
bool is_reference_on_mesh(const Result &result);

/// The results of each table: those of one regime and one reference, small deformations first, references in the order
/// in which they appear. Where nothing was compared there is no number to confuse: such results stand with the first
/// of their regime.
std::vector<std::vector<Result>> groups_by_reference(std::span<const Result> results);

/// The part of the load that models are compared at: below 1 where the reference has no solution beyond it.
double compared_part(const Result &result);

/// "Errors are against fem_p2p1_refined, which was solved on refined meshes; +- is its own uncertainty." Where nothing
/// is compared, why.
/// @param results  of one reference
std::string reference_sentence(std::span<const Result> results);

/// A load of the small regime is too large for it where the reference moves further than this many times the target of
/// the load case, and than this part of the size of the body: linear elasticity judges nothing there. A target alone
/// would not do, since a pressure of 0.1 mm at a Poisson's ratio of 0.45 is one of 0.5 mm at 0.25.
inline constexpr double farthest_beyond_target = 3.0, largest_small_part = 0.01;

/// The largest displacement of the reference at rest [m]; 0 where nothing was compared.
double peak_of_reference(const Result &result);

/// The displacement beyond which a problem of the small regime leaves it: the larger of the two [m].
double largest_small_displacement(const core::Problem &problem);

/// Whether a load case of small deformations moves the body too far to be one, see above.
bool leaves_regime(const Result &result);

/// Whether the reference is at rest at the end of its way, as where a ball has slid off: models that have come to an
/// end have no ratios to it (core::Comparison).
bool ends_at_rest(const Result &result);

/// Whether means and medians of static errors count a result: as is_plain_static() says, compared with a reference that
/// moves, at the whole load, and inside its regime.
bool counts_in_means(const Result &result);

/// The names of the load cases of a body that count, in alphabetical order.
std::vector<std::string> counted_load_cases(std::span<const Result> results, const std::string &body,
                                            double poisson_ratio);

/// One model under one load case.
struct CountedCase {
    const ModelResult *model;
    const Result *result;
};

/// Cases of each of these load cases that has the model; of several results the last. They point into the results.
std::vector<CountedCase> counted_cases(std::span<const Result> results, const std::string &body, double poisson_ratio,
                                       const std::string &model);

/// Status of a model in tables: its own, but "not compared", "out of regime" and "nothing touches" or "at rest"
/// where it has found a solution and the reference has not, the load leaves its regime, or nothing moves the reference
/// at the end; "ok to 80 %" where the reference has none beyond; and "reference" of one that is alone.
std::string shown_status(const ModelResult &model, const Result &result);

/// A sentence for each result whose models are not "ok" for such a reason.
std::vector<std::string> result_remarks(std::span<const Result> results);

} // namespace livermark::results
