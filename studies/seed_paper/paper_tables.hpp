#pragma once

#include <vector>

#include "report/sections.hpp"

namespace livermark::studies {

/// Table 1 of the seed paper beside what result files say of springs: for each body the first that has those of Lloyd
/// in it. Its damping is that of the load case with a release, or of a stability file of the body; without either
/// nothing stands beside the printed damping.
std::vector<report::PaperTable> paper_tables(const report::ReportData &data);

} // namespace livermark::studies
