#pragma once

#include <string>
#include <vector>

#include "results/tables/table_layout.hpp"
#include "studies/report/report_data.hpp"

namespace livermark::studies {

/// Table 1 of the seed paper beside a body.
struct PaperTable {
    std::string body;
    results::Layout rows;
    std::vector<std::string> objections; ///< sentences: what does not follow
    std::string command;                 ///< that made what stands beside the paper's numbers
};

/// Table 1 of the seed paper beside what result files say of springs: for each body the first that has those of Lloyd
/// in it. Its damping is that of the load case with a release, or of a stability file of the body; without either
/// nothing stands beside the printed damping.
std::vector<PaperTable> paper_tables(const ReportData &data);

} // namespace livermark::studies
