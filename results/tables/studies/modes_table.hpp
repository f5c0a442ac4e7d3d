#pragma once

#include "results/records/result.hpp"
#include "results/tables/table_layout.hpp"

namespace livermark::results {

/// Frequencies of each model in Hz, a row for each mode and the seconds last; beside them how far each frequency is
/// from that of the reference, and the modal assurance criterion of the shapes, which tells whether modes of one number
/// are the same.
/// @param result     every model with as many modes
/// @param reference  name of a model; without it frequencies stand alone
Layout modes_table(const Result &result, std::string_view reference);

} // namespace livermark::results
