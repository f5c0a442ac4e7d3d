#pragma once

#include <map>
#include <span>
#include <string>

#include "results/result.hpp"

namespace livermark::app {

enum class TableKind { all, models, summary, overview, means };

/// By their words on the command line.
inline const std::map<std::string, TableKind> table_kinds{{"all", TableKind::all},
                                                          {"models", TableKind::models},
                                                          {"summary", TableKind::summary},
                                                          {"overview", TableKind::overview},
                                                          {"means", TableKind::means}};

/// Prints what results say, to standard output: a row for each model, the summary by load case and, where bodies are
/// there with several Poisson's ratios or when asked for, the overview by these. The means over load cases by body only
/// when asked for.
void print_tables(std::span<const results::Result> results, TableKind kind, bool markdown);

} // namespace livermark::app
