#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/problem.hpp"
#include "core/support/files.hpp"
#include "results/hdf5/io/columns.hpp"
#include "results/hdf5/io/hdf5_io.hpp"
#include "results/records/result.hpp"

/// Parts of several kinds of files that Livermark writes. Internal to results/.
namespace livermark::results::hdf5 {

/// The attributes of the root that say where a file comes from.
void write_provenance(OutputFile &file, const Provenance &provenance);

/// @throws support::InputError if one of them is missing or cannot be
Provenance read_provenance(const InputFile &file);

/// @throws support::InputError for a file of another version, or of another program
void check_schema(const InputFile &file);

/// @throws support::InputError for a value that no material has
void check_materials(const GroupReader &group, const std::vector<core::Material> &materials);

/// Body, load case and title of a record, as attributes of the root.
template <class At, class Record> void describe_head(At root, Record &record) {
    root.text("body", record.body);
    root.text("load_case", record.load_case);
    root.text("title", record.title);
}

/// The group /materials, a row for each region.
/// @param num_regions  nothing where the file decides
template <class At>
void describe_materials(At at, Of<At, std::vector<core::Material>> &materials, const Count &num_regions = {}) {
    const auto group = at.group("materials");
    auto columns = columns_of(group, materials, num_regions);
    columns.column("density", &core::Material::density, "kg/m^3");
    columns.column("young_modulus", &core::Material::young_modulus, "Pa");
    columns.column("poisson_ratio", &core::Material::poisson_ratio);
    if constexpr (At::reads)
        check_materials(group, materials);
}

/// Writes a file of one record and where it comes from, as write_result() writes results.
/// @param describe  of the root of the file and the record
/// @throws support::InputError if the place cannot be written to
template <class Record, class Describe>
void write_record(const std::filesystem::path &path, const Record &record, Describe describe) {
    OutputFile file;
    write_provenance(file, record.provenance);
    describe(GroupWriter(file), record);
    support::write_whole(path, file.image());
}

/// Reads what write_record wrote.
/// @param maker  the command that writes such files, for messages
/// @throws support::InputError that names the file and the dataset or attribute, and says what is wrong and what to do
template <class Record, class Describe>
Record read_record(const std::filesystem::path &path, const std::string &maker, Describe describe) {
    return read_once_tried(path, [&] {
        const InputFile file(path, maker);
        check_schema(file);
        Record record;
        record.provenance = read_provenance(file);
        describe(GroupReader(file), record);
        return record;
    });
}

} // namespace livermark::results::hdf5
