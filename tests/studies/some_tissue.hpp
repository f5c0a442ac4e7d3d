#pragma once

#include <Eigen/Cholesky>
#include <cmath>
#include <fmt/format.h>
#include <random>
#include <string>
#include <vector>

#include "core/tool/needle/needle_line.hpp"
#include "results/records/needle.hpp"
#include "studies/needle/insertion.hpp"
#include "tests/studies/random_insertions.hpp"

namespace livermark::tests {

inline core::Needle needle_of_some_tissue() {
    return {.name = "needle",
            .entry = {0.01, 0.02, 0.03},
            .target = {0.01, 0.06, 0.06},
            .diameter = 1e-3,
            .spread = 6e-3,
            .toughness = 200.0,
            .friction = 10.0,
            .puncture_force = 0.2,
            .step = 2.5e-4};
}

/// Tissue whose places give way the less for each other the farther they are apart, and not along the axis alone.
inline Eigen::MatrixXd some_tissue(const core::NeedleLine &line, double compliance, double reach,
                                   std::mt19937 &random) {
    std::normal_distribution<double> normal;
    Eigen::Matrix3d root;
    for (double &entry : root.reshaped())
        entry = normal(random);
    const Eigen::Matrix3d block = Eigen::Matrix3d::Identity() + 0.2 * root * root.transpose();
    const auto places = static_cast<Eigen::Index>(line.places.size());
    Eigen::MatrixXd matrix(3 * places, 3 * places);
    for (Eigen::Index i = 0; i < places; ++i)
        for (Eigen::Index j = 0; j < places; ++j)
            matrix.block<3, 3>(3 * i, 3 * j) =
                compliance * std::exp(-line.spacing * static_cast<double>(std::abs(i - j)) / reach) * block;
    return matrix;
}

/// Random needles in random tissue.
/// @param least_spread  of the places [m]: the narrower, the more of them
/// @return a sentence for each with a fault
inline std::vector<std::string> drive_into_some_tissue(unsigned seed, int count, double least_spread) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> part;
    std::vector<std::string> faults;
    for (int n = 0; n < count; ++n) {
        auto some = needle_of_some_tissue();
        some.spread = least_spread + 0.01 * part(random);
        some.toughness = 20.0 + 300.0 * part(random);
        some.friction = n % 5 == 0 ? 0.0 : 60.0 * part(random);
        some.puncture_force = some.tip_force();
        const auto line = core::needle_line(some);
        const double compliance = std::pow(10.0, -3.0 + part(random));
        results::NeedleRun run;
        run.insertion = studies::insert(some_tissue(line, compliance, 0.005 + 0.05 * part(random), random), line, some);
        auto fault = fault_of(run.insertion, some, run.energy_error());
        if (fault.empty() && std::abs(run.insertion.force.back()) > 1e-6)
            fault = fmt::format("{} N are left when it is out", run.insertion.force.back());
        if (!fault.empty())
            faults.push_back(fmt::format("{}: compliance {}, friction {}, spread {}: {}", n, compliance, some.friction,
                                         some.spread, fault));
    }
    return faults;
}

} // namespace livermark::tests
