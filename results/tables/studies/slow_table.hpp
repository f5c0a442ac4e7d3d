#pragma once

#include <span>
#include <string>

#include "results/records/result.hpp"
#include "results/tables/table_layout.hpp"

namespace livermark::results {

/// Of load cases in which time passes in the material, others are left out: a row for each model and tool, with the
/// force at the whole load when it is first reached, at the last record of the whole load and what that is of the
/// first; how far the force over time is from that of the reference; and the heat of the last cycle. Of a given
/// traction the displacement takes the place of the force.
Layout slow_table(std::span<const Result> results);

/// What the columns mean.
std::string slow_legend();

} // namespace livermark::results
