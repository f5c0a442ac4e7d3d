#pragma once

#include <string>

#include "studies/report/report_data.hpp"

namespace livermark::studies {

/// What the Python program livermark.report is told beside the files themselves, as JSON: which files there are, and
/// the tables that `livermark table` and others print too, so that each is made in one place.
/// python/livermark/report/data.py reads it.
/// @param command_line  that makes the report again
std::string report_tables(const ReportData &data, const std::string &command_line);

} // namespace livermark::studies
