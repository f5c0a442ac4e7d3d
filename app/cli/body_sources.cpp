#include "app/cli/body_sources.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string_view>
#include <utility>

#include "app/cli/segment_program.hpp"
#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/support/processes/child_process.hpp"
#include "core/support/toml_input.hpp"

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

/// Names that a line of a header may have: each of its words, all of it, and all behind its key, because names have
/// spaces.
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

/// Files that belong to a file or folder, in an order that does not depend on the disk.
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

/// File that `livermark-segment` writes when it is given these words and --output.
std::string json_of(std::vector<std::string> words) {
    const support::ScratchFolder scratch;
    const auto file = scratch.path / "image.json";
    words.insert(words.end(), {"--output", file.string()});
    segment(std::move(words));
    return support::read_text(file);
}

std::string content_of(const std::vector<std::string> &sources) {
    support::FnvHash hash;
    for (const auto &source : sources)
        for (const auto &file : all_files(source))
            add_content(hash, file);
    return fmt::format("{:016x}", hash.value());
}

/// Start of the options of a body of labels, and the words between what they say; see sources_of().
constexpr std::string_view labels_start = "labels, liver ", tumours_start = ", tumours ", roles_start = ", roles ",
                           tetrahedra_start = ", tetrahedra ";

/// Parts of a text in front of a mark and behind it.
std::pair<std::string_view, std::string_view> split_at(std::string_view text, std::string_view mark) {
    const auto at = text.find(mark);
    if (at == std::string_view::npos)
        return {text, {}};
    return {text.substr(0, at), text.substr(at + mark.size())};
}

/// Roles as they were given: NAME=ROLE, one behind the other with commas, which names have as well.
std::vector<std::string> roles_in(std::string_view text) {
    std::vector<std::string> roles;
    while (!text.empty()) {
        const auto end = text.find(',', std::min(text.find('='), text.size()));
        roles.emplace_back(text.substr(0, end));
        text.remove_prefix(std::min(end, text.size() - 1) + 1);
    }
    return roles;
}

/// The choice of labels that options say, as words for `livermark-segment`.
std::vector<std::string> words_of_choice(std::string_view options) {
    options = options.substr(labels_start.size(), options.rfind(tetrahedra_start) - labels_start.size());
    const auto [liver, others] = split_at(options, tumours_start);
    const auto [tumours, roles] = split_at(others, roles_start);
    std::vector<std::string> words;
    if (!liver.empty())
        words.insert(words.end(), {"--liver", std::string(liver)});
    if (!tumours.empty())
        words.insert(words.end(), {"--tumours", std::string(tumours)});
    for (const auto &role : roles_in(roles))
        words.push_back("--role=" + role);
    return words;
}

/// A label image, and the choice of its labels.
struct ChosenImage {
    std::string file;
    std::vector<std::string> choice; ///< words for `livermark-segment`
};

/// The label image that a body was made of.
/// @throws support::InputError  if the body was made of something else, or the image went or has changed since
ChosenImage image_of(const fs::path &body_file) {
    const auto known = sources_in(body_file);
    if (!known || !known->options.starts_with(labels_start) || known->files.size() != 1)
        throw support::InputError("{}: this body was not made of a label image, so there is none to be shown",
                                  body_file.string());
    const auto &file = known->files.front();
    if (std::error_code error; !fs::exists(file, error))
        throw support::InputError("{}: the label image of this body is not there any more; put it back, or make the "
                                  "body again with `livermark run --body IMAGE`",
                                  file);
    if (content_of(known->files) != known->content)
        throw support::InputError("{}: this label image has changed since the body was made of it; put the old one "
                                  "back, or make the body again with `livermark run --body IMAGE`",
                                  file);
    return {file, words_of_choice(known->options)};
}

} // namespace

BodySources sources_of(const SegmentCommand &command) {
    const bool is_image = !command.labels.empty();
    BodySources sources;
    sources.options = is_image ? fmt::format("{}{}{}{}", labels_start, fmt::join(command.liver, ","), tumours_start,
                                             fmt::join(command.tumours, ","))
                               : fmt::format("surfaces, unit {}", command.unit.value_or("guessed"));
    if (!command.roles.empty())
        sources.options += fmt::format("{}{}", roles_start, fmt::join(command.roles, ","));
    sources.options += fmt::format("{}{}", tetrahedra_start, command.tetrahedra);
    for (const auto &source : is_image ? std::vector{command.labels} : command.surfaces) {
        std::error_code error;
        if (!fs::is_directory(source, error))
            support::check_readable(source);
        sources.files.push_back(fs::absolute(source).lexically_normal().string());
    }
    sources.content = content_of(sources.files);
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

std::vector<fs::path> body_files_of(const fs::path &result, const std::string &body, const fs::path &folder) {
    if (fs::path(body).filename() != body)
        return {}; // a file may say any name
    const auto name = body + ".toml";
    return {result.parent_path().parent_path() / name, folder / name};
}

std::string slices_of_image(const fs::path &body_file, const core::Vector3 &at) {
    if (support::file_ending(body_file) != ".toml" || !has_segment_program())
        return "";
    std::string image;
    try {
        image = image_of(body_file).file;
    } catch (const support::InputError &) {
        return ""; // there is no such body file, or it is damaged, or of something else
    }
    // = because a coordinate below zero looks like an option.
    return json_of({"slices", image, fmt::format("--at={:.9g},{:.9g},{:.9g}", at.x(), at.y(), at.z())});
}

std::string voxels_of_image(const std::vector<fs::path> &body_files) {
    const auto is_there = [](const fs::path &file) {
        std::error_code error;
        return fs::exists(file, error);
    };
    const auto body_file = std::ranges::find_if(body_files, is_there);
    if (body_file == body_files.end())
        throw support::InputError(
            "{}: this file is not there, which says what image the body was made of; `livermark run "
            "--body IMAGE` writes it there",
            body_files.empty() ? "the file of the body" : body_files.front().string());
    const auto image = image_of(*body_file);
    if (!has_segment_program())
        throw support::InputError("images are read by livermark-segment, which is not built here; build it with {}",
                                  command_that_builds);
    std::vector<std::string> words{"voxels", image.file};
    words.insert(words.end(), image.choice.begin(), image.choice.end());
    return json_of(std::move(words));
}

} // namespace livermark::cli
