#include "results/records/experiment.hpp"

#include <algorithm>
#include <cmath>

namespace livermark::results {

MarkerError marker_error(const ExperimentResult &result, const std::vector<core::Vector3> &displacement,
                         const std::vector<core::Vector3> &measured) {
    double sum = 0.0, largest = 0.0;
    int count = 0;
    for (std::size_t k = 0; k < measured.size(); ++k) {
        if (!result.is_compared(k) || !measured[k].allFinite())
            continue;
        const double square = (displacement[k] - measured[k]).squaredNorm();
        sum += square;
        largest = std::max(largest, square);
        ++count;
    }
    const double root_mean_square = std::sqrt(sum / count);
    return {root_mean_square, std::isfinite(root_mean_square) ? std::sqrt(largest) : root_mean_square};
}

double root_mean_square_distance(const std::vector<core::Vector3> &a, const std::vector<core::Vector3> &b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i)
        sum += (a[i] - b[i]).squaredNorm();
    return std::sqrt(sum / static_cast<double>(a.size()));
}

} // namespace livermark::results
