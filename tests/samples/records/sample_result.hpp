#pragma once

#include "results/records/result.hpp"

namespace livermark::tests {

/// A result with everything that a result can hold, on a box of two regions and the given number of bricks along x:
/// "fem_p2", the reference; "springs", compared, with springs; "blown_up", diverged, with NaN and infinity in its
/// displacement; "unfinished", without comparison. The reference has an uncertainty of 19 %, a little less than the
/// error of "springs". The numbers are made up: no model was solved.
results::Result sample_result(int num_bricks = 2);

/// A model named "stiffer" that differs from one with springs in their stiffness alone.
results::ModelResult stiffer(results::ModelResult model);

/// The result with two balls that close in place of one that slides.
results::Result with_jaws(results::Result result);

/// A result under a load case that does not depend on time, but has a path of loads, and no ball.
results::Result along_a_path(results::Result result);

/// A result under a load case that has neither.
results::Result without_motion(results::Result result);

} // namespace livermark::tests
