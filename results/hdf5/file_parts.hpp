#pragma once

#include <functional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "core/material.hpp"
#include "results/hdf5/io/hdf5_io.hpp"
#include "results/records/result.hpp"

/// What several kinds of files that Livermark writes have in common. Internal to results/.
namespace livermark::results::hdf5 {

/// The attributes of the root that say where a file comes from.
void write_provenance(OutputFile &file, const Provenance &provenance);

/// @throws support::InputError if one of them is missing or cannot be
Provenance read_provenance(const InputFile &file);

/// @throws support::InputError for a file of another version, or of another program
void check_schema(const InputFile &file);

/// A dataset of one value of each row.
/// @param value  a member of the row, or a function of it
template <class Row, class Value>
void write_column(OutputFile &file, const std::string &path, const std::vector<Row> &rows, Value value,
                  const std::string &units = "") {
    std::vector<std::decay_t<std::invoke_result_t<Value, const Row &>>> column;
    for (const auto &row : rows)
        column.push_back(std::invoke(value, row));
    file.dataset(path, column, units);
}

/// The group /materials, a row for each region.
void write_materials(OutputFile &file, std::span<const core::Material> materials);

/// @throws support::InputError for another number of rows, or a value that no material has
std::vector<core::Material> read_materials(const InputFile &file, std::size_t num_regions);

} // namespace livermark::results::hdf5
