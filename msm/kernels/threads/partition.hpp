#pragma once

#include "msm/kernels/step_workspace.hpp"

namespace livermark::msm {

/// Gives each thread its part of the work on a body, of about the same cost.
/// @param workspace    with its body
/// @param num_threads  >= 1
template <class T> void partition_work(StepWorkspace<T> &workspace, int num_threads);

} // namespace livermark::msm
