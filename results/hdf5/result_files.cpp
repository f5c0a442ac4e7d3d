#include "results/hdf5/result_files.hpp"

#include <algorithm>
#include <cctype>
#include <fmt/format.h>
#include <string>
#include <system_error>

#include "results/bodies_apart.hpp"
#include "results/hdf5/file_kind.hpp"
#include "results/hdf5/result_file.hpp"
#include "support/input_error.hpp"

namespace livermark::results {

namespace {

/// The result files below a folder, by name. Other commands leave other files there.
/// @return how many files cannot be read
int add_results_below(const std::filesystem::path &path, std::vector<Result> &results) {
    int num_passed_over = 0;
    for (const auto &file : hdf5_files_below(path))
        try {
            if (kind_of_file(file) == FileKind::cohort) // sums up the files below it
                continue;
            else if (auto result = read_result(file); !result.models.empty()) // modes have files of the same kind
                results.push_back(std::move(result));
        } catch (const support::InputError &fault) {
            std::string sentence = fault.what(); // with names out of the file
            std::ranges::replace_if(
                sentence, [](char c) { return std::iscntrl(static_cast<unsigned char>(c)) != 0; }, ' ');
            fmt::print(stderr, "livermark: passed over: {}\n", sentence);
            ++num_passed_over;
        }
    return num_passed_over;
}

} // namespace

std::vector<std::filesystem::path> hdf5_files_below(const std::filesystem::path &folder) {
    std::error_code error;
    std::vector<std::filesystem::path> found;
    for (auto entry = std::filesystem::recursive_directory_iterator(folder, error);
         !error && entry != std::filesystem::recursive_directory_iterator(); entry.increment(error))
        if (entry->path().extension() == ".h5")
            found.push_back(entry->path());
    if (error)
        throw support::InputError(
            fmt::format("{}: cannot be listed ({}); check its permissions", folder.string(), error.message()));
    std::ranges::sort(found);
    return found;
}

std::vector<Result> read_results(std::span<const std::filesystem::path> paths) {
    std::vector<Result> results;
    int num_passed_over = 0;
    for (const auto &path : paths)
        if (std::error_code ignored; std::filesystem::is_directory(path, ignored))
            num_passed_over += add_results_below(path, results);
        else
            results.push_back(read_result(path));
    if (results.empty()) {
        std::vector<std::string> names;
        for (const auto &path : paths)
            names.push_back(path.string());
        if (num_passed_over > 0)
            throw support::InputError(
                fmt::format("{}: no result file here can be read; the reasons stand above", fmt::join(names, ", ")));
        throw support::InputError(
            fmt::format("{}: there are no result files here; make some with `livermark run`", fmt::join(names, ", ")));
    }
    for (const auto &note : tell_bodies_apart(results))
        fmt::print(stderr, "livermark: {}\n", note);
    return results;
}

bool is_shown_on_page(const std::filesystem::path &path) {
    try {
        const auto kind = kind_of_file(path);
        return kind == FileKind::result || kind == FileKind::experiment;
    } catch (const FileInUse &) {
        throw;
    } catch (const support::InputError &) {
        return false;
    }
}

} // namespace livermark::results
