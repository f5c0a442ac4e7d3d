#include "results/hdf5/result_file.hpp"

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <fmt/format.h>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "results/hdf5/hdf5_io.hpp"
#include "results/hdf5/references.hpp"

namespace livermark::results {

namespace {

FileKind kind_in(const std::filesystem::path &path) {
    const hdf5::InputFile file(path);
    if (file.has("/critical_time_step"))
        return FileKind::stability;
    if (file.has("/timings"))
        return FileKind::timings;
    if (file.has("/bodies") && file.has("/errors"))
        return FileKind::cohort;
    if (file.has("/arena"))
        return FileKind::arena;
    if (file.has("/needles"))
        return FileKind::needle;
    if (file.has("/experiment"))
        return FileKind::experiment;
    if (file.has("/sensitivity"))
        return FileKind::sensitivity;
    if (file.has("/loads") && file.has("/springs"))
        return FileKind::calibration;
    if (file.has("/solutions") && !file.children("/solutions").empty())
        return FileKind::result;
    return file.has("/modes") ? FileKind::modes : FileKind::other;
}

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

template <class Row> std::string_view bytes_of(const std::vector<Row> &rows) {
    return {reinterpret_cast<const char *>(rows.data()), rows.size() * sizeof(Row)};
}

std::uint32_t digits_of(const core::TetraMesh &mesh) {
    support::FnvHash hash;
    hash.add(bytes_of(mesh.points));
    hash.add(bytes_of(mesh.tetrahedra));
    hash.add(bytes_of(mesh.region));
    return static_cast<std::uint32_t>(hash.value() >> 32);
}

} // namespace

FileKind kind_of_file(const std::filesystem::path &path) {
    return hdf5::read_once_tried(path, [&] { return kind_in(path); });
}

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

std::string body_in(const std::filesystem::path &path) {
    return hdf5::read_once_tried(path, [&] { return hdf5::InputFile(path).text("/", "body"); });
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

std::optional<Result> resumable_result(const std::filesystem::path &file, const core::Problem &problem,
                                       const Provenance &provenance) {
    std::error_code error;
    if (!std::filesystem::exists(file, error))
        return {};
    try {
        auto kept = read_result(file);
        if (kept.provenance.command == provenance.command && kept.provenance.git_commit == provenance.git_commit &&
            kept.provenance.build_type == provenance.build_type && problem_key(kept.problem) == problem_key(problem))
            return kept;
    } catch (const support::InputError &) {
        return {}; // not a whole result file, so nothing to go on from
    }
    return {};
}

std::vector<std::string> tell_bodies_apart(std::span<Result> results) {
    std::vector<std::uint32_t> digits;
    std::map<std::string, std::map<std::uint32_t, std::string>> names; // by body and digits
    for (const auto &result : results) {
        const auto &body = *result.problem.body;
        digits.push_back(digits_of(body.mesh));
        names[body.name][digits.back()] = fmt::format("{}#{:08x}", body.name, digits.back());
    }
    std::vector<std::string> sentences;
    for (const auto &[name, meshes] : names) {
        if (meshes.size() < 2)
            continue;
        std::vector<std::string> apart;
        for (const auto &[mesh, own_name] : meshes)
            apart.push_back(own_name);
        sentences.push_back(fmt::format("result files of {} different bodies have the name {}; they are called {}",
                                        meshes.size(), name, fmt::join(apart, ", ")));
    }
    for (std::size_t r = 0; r < results.size(); ++r)
        if (const auto &meshes = names[results[r].problem.body->name]; meshes.size() > 1) {
            auto body = std::make_shared<core::Body>(*results[r].problem.body);
            body->name = meshes.at(digits[r]);
            results[r].problem.body = std::move(body);
        }
    return sentences;
}

} // namespace livermark::results
