#pragma once

#include <string>
#include <vector>

#include "report/report_data.hpp"
#include "report/sections.hpp"

namespace livermark::report {

/// A report as one HTML file that needs nothing else: no network, no script, pictures inside. It is the same for the
/// same data.
/// @param command_line  that makes it again, shown in it
std::string make_report(const ReportData &data, const std::vector<PaperTable> &paper, const std::string &command_line);

} // namespace livermark::report
