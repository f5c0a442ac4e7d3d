#include "cli/body_sources.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <fstream>
#include <sstream>

#include "support/file_ending.hpp"
#include "support/fnv_hash.hpp"
#include "support/input_error.hpp"
#include "support/toml_input.hpp"
#include "support/whole_file.hpp"

namespace livermark::cli {

namespace {

namespace fs = std::filesystem;

void add_content(support::FnvHash &hash, const fs::path &file) {
    std::ifstream stream(file, std::ios::binary);
    std::array<char, 1 << 16> buffer{};
    while (stream.read(buffer.data(), buffer.size()) || stream.gcount() > 0)
        hash.add_bytes({buffer.data(), static_cast<std::size_t>(stream.gcount())});
    hash.add(""); // the end of the file
}

std::vector<fs::path> files_in(const fs::path &folder) {
    std::vector<fs::path> files;
    std::error_code error;
    for (auto entry = fs::directory_iterator(folder, error); !error && entry != fs::directory_iterator();
         entry.increment(error))
        if (std::error_code ignored; entry->is_regular_file(ignored))
            files.push_back(entry->path());
    std::ranges::sort(files);
    return files;
}

/// What a line of a header may name: each of its words, all of it, and all behind its key, because names have spaces.
std::vector<std::string> names_in(const std::string &line) {
    std::vector<std::string> names;
    std::istringstream words(line);
    for (std::string word; words >> word;)
        names.push_back(word);
    for (const auto begin : {std::size_t{0}, line.find_first_of(":=") + 1}) {
        const auto first = line.find_first_not_of(" \t\r=", begin);
        if (names.size() > 1 && first != std::string::npos)
            names.push_back(line.substr(first, line.find_last_not_of(" \t\r") + 1 - first));
    }
    return names;
}

/// Files beside a header that are named in it; all of them if it names a pattern, such as slice_%03d.raw.
std::vector<fs::path> data_files(const fs::path &header) {
    std::vector<fs::path> files;
    const auto folder = fs::absolute(header).parent_path();
    std::ifstream stream(header);
    for (std::string line; std::getline(stream, line) && files.size() < 10000;) {
        if (line.find('%') != std::string::npos)
            return files_in(folder);
        for (const auto &name : names_in(line))
            if (std::error_code error; fs::is_regular_file(folder / name, error))
                files.push_back(folder / name);
    }
    return files;
}

/// What belongs to a file or folder, in an order that does not depend on the disk.
std::vector<fs::path> all_files(const fs::path &source) {
    std::vector<fs::path> files;
    std::error_code error;
    const auto ending = support::file_ending(source);
    if (fs::is_directory(source, error))
        return files_in(source);
    files.push_back(source);
    if (ending == ".mhd" || ending == ".nhdr")
        std::ranges::copy(data_files(source), std::back_inserter(files));
    if (ending == ".hdr" || ending == ".img")
        for (const auto *other : {".hdr", ".img", ".img.gz", ".HDR", ".IMG", ".IMG.GZ"})
            if (auto pair = fs::path(source).replace_extension(other);
                pair != source && fs::is_regular_file(pair, error))
                files.push_back(std::move(pair));
    return files;
}

std::string quoted_text(const std::string &text) {
    std::ostringstream stream;
    stream << toml::value<std::string>(text);
    return stream.str();
}

} // namespace

BodySources sources_of(const SegmentCommand &command) {
    const bool is_image = !command.labels.empty();
    BodySources sources;
    sources.options = is_image ? fmt::format("labels, liver {}, tumours {}", fmt::join(command.liver, ","),
                                             fmt::join(command.tumours, ","))
                               : fmt::format("surfaces, unit {}", command.unit.value_or("guessed"));
    sources.options += fmt::format(", tetrahedra {}", command.tetrahedra);
    support::FnvHash hash;
    for (const auto &source : is_image ? std::vector{command.labels} : command.surfaces) {
        std::error_code error;
        if (!fs::is_directory(source, error))
            support::check_readable(source);
        sources.files.push_back(fs::absolute(source).lexically_normal().string());
        for (const auto &file : all_files(source))
            add_content(hash, file);
    }
    sources.content = fmt::format("{:016x}", hash.value());
    return sources;
}

std::string sources_toml(const BodySources &sources) {
    auto text = std::string("[image.made_of] # the body is made anew where options or content differ\nfiles = [\n");
    for (const auto &file : sources.files)
        text += fmt::format("  {},\n", quoted_text(file));
    return text + fmt::format("]\noptions = {}\ncontent = \"{}\"\n", quoted_text(sources.options), sources.content);
}

std::optional<BodySources> sources_in(const fs::path &body_file) {
    const auto body = support::parse_toml(support::read_text(body_file), body_file);
    const auto *table = body["image"]["made_of"].as_table();
    if (!table)
        return std::nullopt;
    BodySources sources{{}, (*table)["options"].value_or(std::string()), (*table)["content"].value_or(std::string())};
    if (const auto *files = (*table)["files"].as_array())
        for (const auto &file : *files)
            sources.files.push_back(file.value_or(std::string()));
    return sources;
}

} // namespace livermark::cli
