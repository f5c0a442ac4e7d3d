#pragma once

#include <string>
#include <vector>

#include "report/report_data.hpp"
#include "results/tables/table_layout.hpp"

/// The parts of a report, a file each. Every one is a section of HTML that says so where something is missing.
namespace livermark::report {

/// Table 1 of the seed paper beside a body.
struct PaperTable {
    std::string body;
    results::Layout rows;
    std::vector<std::string> objections; ///< sentences: what does not follow
    std::string command;                 ///< that made what stands beside the paper's numbers
};

std::string head(const ReportData &data);
std::string errors_section(const ReportData &data);
std::string large_section(const ReportData &data);
std::string cohort_section(const ReportData &data);
std::string cost_section(const ReportData &data);
std::string poisson_section(const ReportData &data);
std::string refinement_section(const ReportData &data);
std::string steps_section(const ReportData &data);
std::string timings_section(const ReportData &data);
std::string paper_section(const ReportData &data, const std::vector<PaperTable> &tables);
std::string pictures_section(const ReportData &data);
std::string appendix(const ReportData &data, const std::string &command_line);

} // namespace livermark::report
