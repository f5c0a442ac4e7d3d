#pragma once

#include <string>
#include <vector>

#include "core/tool/needle/needle.hpp"

namespace livermark::results {

/// A model beside a measured needle: what was fitted, and what came out.
struct FittedNeedle {
    std::string model;
    double stiffness = 1.0;    ///< by which all of Young's moduli are multiplied, fitted to the depth of the puncture
    double friction = 0.0;     ///< fitted to the forces behind the puncture [N/m]
    core::Insertion insertion; ///< on the way in and out
    std::vector<double> force; ///< (B) its mean in each stretch of the measurement [N]; NaN where it has no record
    double error = 0.0;        ///< root mean square of force less measured mean, behind the puncture [N]
    double error_before = 0.0; ///< the same before it [N]
    double work = 0.0;         ///< of the hand, over all stretches [J]
};

/// Models beside what was measured at the handle of a needle.
struct MeasuredNeedle {
    std::string source;
    std::vector<std::string> unknown;
    core::Needle needle; ///< with what is not fitted: diameter, radius of the places, toughness, force of the puncture
    std::vector<double> from, to, mean, lowest, highest; ///< (B) stretches of the way [m], and the forces there [N]
    double puncture_depth = 0.0;                         ///< [m]
    double work = 0.0;                                   ///< of the hand, measured, over all stretches [J]
    std::vector<FittedNeedle> runs;
};

} // namespace livermark::results
