#pragma once

#include <string>
#include <vector>

#include "core/problem.hpp"
#include "core/solution.hpp"

namespace livermark::studies {

/// What is asked of a solution.
enum class Output { stiffness_at_tool, peak_displacement, tumour_displacement };

const char *name_of(Output output);
const char *unit_of(Output output);

/// What a body under a load case is asked: where it has tools, the stiffness at the first of them; how far the node
/// that moves most moves; and how far the centroid of the largest tumour moves, if it has one.
std::vector<Output> outputs_of(const core::Problem &nominal);

/// The outputs of a solution.
struct OutputValues {
    std::vector<double> values{}; ///< (O) stiffness [N/m], displacements [m]; NaN of a solution that is not ok
    core::Vector3 tumour = core::Vector3::Zero(); ///< displacement of the tumour [m]
};

/// @param problem  that was solved; nodes and regions of the nominal one come first
OutputValues values_of(const std::vector<Output> &outputs, const core::Problem &nominal, const core::Problem &problem,
                       const core::Solution &solution);

/// What some values are off from others by, relative to these: signed, but for the place of a tumour the length of the
/// difference.
std::vector<double> relative_differences(const std::vector<Output> &outputs, const OutputValues &values,
                                         const OutputValues &reference);

} // namespace livermark::studies
