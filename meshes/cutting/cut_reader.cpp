#include "meshes/cutting/cut_reader.hpp"

#include <algorithm>
#include <cctype>
#include <fmt/format.h>
#include <limits>
#include <sstream>
#include <toml++/toml.h>

#include "core/support/files.hpp"
#include "core/support/toml_input.hpp"
#include "meshes/anatomy/liver_patches.hpp"
#include "meshes/io/mesh_files.hpp"

namespace livermark::meshes {

namespace {

std::optional<std::string> optional_word(const toml::table &table, const char *key) {
    return table.contains(key) ? std::optional(support::required_string(table, key)) : std::nullopt;
}

std::optional<double> optional_length(const toml::table &table, const char *key) {
    return table.contains(key) ? std::optional(support::required_number(table, key)) : std::nullopt;
}

/// All numbers of a list of lists; what is no number becomes one that no blade has.
std::vector<double> numbers_in(const toml::array *lists) {
    std::vector<double> numbers;
    if (lists)
        for (const auto &list : *lists)
            if (const auto *row = list.as_array())
                for (const auto &number : *row)
                    numbers.push_back(number.value<double>().value_or(std::numeric_limits<double>::quiet_NaN()));
    return numbers;
}

CutWords words_of(const toml::table &cut) {
    support::refuse_unknown_keys(cut, {"region", "margin", "half_space", "blade", "way", "small_pieces"});
    CutWords words;
    words.region = optional_word(cut, "region");
    words.margin = optional_length(cut, "margin");
    if (cut.contains("half_space")) {
        const auto &half_space = support::required_table(cut, "half_space");
        support::refuse_unknown_keys(half_space, {"point", "normal"});
        for (const char *key : {"point", "normal"})
            for (const double component : support::required_vector(half_space, key))
                words.half_space.push_back(component);
    }
    if (cut.contains("blade")) {
        const auto &blade = support::required_table(cut, "blade");
        support::refuse_unknown_keys(blade, {"corners", "thickness"});
        words.blade = numbers_in(blade.get_as<toml::array>("corners"));
        words.blade.resize(std::max<std::size_t>(words.blade.size(), 1)); // it is there, though empty
        words.thickness = optional_length(blade, "thickness");
    }
    words.way = optional_word(cut, "way").value_or(words.way);
    words.small_pieces = optional_word(cut, "small_pieces").value_or(words.small_pieces);
    return words;
}

CutTool tool_of(const CutWords &words, const std::string &place) {
    const auto refuse = [&](const char *what) { throw support::InputError("{}: {}", place, what); };
    if (int{words.region.has_value()} + int{!words.half_space.empty()} + int{!words.blade.empty()} != 1)
        refuse("a cut needs a region, a half-space or a blade; give one of them");
    if (words.margin && !words.region)
        refuse("a margin needs a region; leave it out, or give a region");
    if (words.thickness && words.blade.empty())
        refuse("a thickness needs a blade; leave it out, or give a blade");
    if (words.region)
        return RegionCut{*words.region, words.margin.value_or(0.0)};
    const auto vector = [](const std::vector<double> &numbers, std::size_t v) {
        return core::Vector3(numbers[3 * v], numbers[3 * v + 1], numbers[3 * v + 2]);
    };
    if (!words.half_space.empty()) {
        if (words.half_space.size() != 6)
            refuse("a half-space needs a point and a normal; give three numbers of each");
        return HalfSpaceCut{vector(words.half_space, 0), vector(words.half_space, 1)};
    }
    if (words.blade.size() != 12)
        refuse("a blade sweeps a quadrilateral; give its four corners in turn, three numbers of each");
    return BladeCut{{vector(words.blade, 0), vector(words.blade, 1), vector(words.blade, 2), vector(words.blade, 3)},
                    words.thickness.value_or(0.0)};
}

CutWay way_of(const std::string &word, const std::string &place) {
    if (word != "facets" && word != "exact")
        throw support::InputError("{}: there is no way '{}' to cut; give facets or exact", place, word);
    return word == "exact" ? CutWay::exact : CutWay::facets;
}

SmallPieces fate_of_small_pieces(const std::string &word, const std::string &place) {
    if (word == "refuse")
        return SmallPieces::refuse;
    if (word == "remove")
        return SmallPieces::remove;
    if (word == "keep")
        return SmallPieces::keep;
    throw support::InputError("{}: there is no way '{}' to treat small pieces; give refuse, remove or keep", place,
                              word);
}

} // namespace

Cut cut_of(const CutWords &words, const std::string &place) {
    return {tool_of(words, place), way_of(words.way, place), fate_of_small_pieces(words.small_pieces, place), place};
}

std::vector<Cut> read_cuts(const toml::table &table) {
    std::vector<Cut> cuts;
    const auto *node = table.get("cut");
    if (!node)
        return cuts;
    if (!node->is_array_of_tables())
        support::refuse(*node, "'cut' is not a list of tables; write [[cut]] above each");
    for (const auto &entry : *node->as_array())
        cuts.push_back(cut_of(words_of(*entry.as_table()), support::place_of(entry)));
    return cuts;
}

std::vector<Cut> cuts_of_file(const std::filesystem::path &toml_file) {
    const auto table = support::parse_toml(support::read_text(toml_file), toml_file);
    auto cuts = read_cuts(table);
    const double metres = cuts.empty() ? 1.0 : support::metres_per_unit(table);
    for (auto &cut : cuts) {
        if (auto *region = std::get_if<RegionCut>(&cut.tool))
            region->margin *= metres;
        if (auto *half_space = std::get_if<HalfSpaceCut>(&cut.tool))
            half_space->point *= metres;
        if (auto *blade = std::get_if<BladeCut>(&cut.tool)) {
            blade->thickness *= metres;
            for (auto &corner : blade->corners)
                corner *= metres;
        }
    }
    return cuts;
}

namespace {

std::string key(const std::string &name) {
    const bool is_bare = std::ranges::all_of(
        name, [](unsigned char c) { return c < 0x80 && (std::isalnum(c) != 0 || c == '_' || c == '-'); });
    return is_bare && !name.empty() ? name : support::quoted(name);
}

std::filesystem::path write_body(std::filesystem::path mesh_file, const core::Body &body, const std::string &title,
                                 const std::string &command) {
    auto text = fmt::format("title = {}\nmesh = {}\ngenerator = {}\n", support::quoted(title),
                            support::quoted(mesh_file.filename().string()), support::quoted(command)) +
                axes_toml(body.axes);
    for (std::size_t region = 0; region < body.materials.size(); ++region) {
        const auto &material = body.materials[region];
        text += fmt::format("\n[regions.{}]\ndensity = {} # kg/m^3\nyoung_modulus = {} # Pa\npoisson_ratio = {}\n"
                            "source = {}\n",
                            key(body.mesh.region_names[region]), material.density, material.young_modulus,
                            material.poisson_ratio, support::quoted(fmt::format("as of {}, which was cut", body.name)));
    }
    write_msh(mesh_file, body.mesh);
    auto body_file = mesh_file.replace_extension(".toml");
    support::write_whole(body_file, text);
    return body_file;
}

} // namespace

std::vector<std::filesystem::path> write_cut_body(const std::filesystem::path &mesh_file, const CutBody &cut,
                                                  const std::string &command) {
    check_name_of_mesh(mesh_file);
    std::vector<std::filesystem::path> files{
        write_body(mesh_file, cut.body, fmt::format("{}, cut", cut.body.name), command)};
    for (std::size_t piece = 0; piece < cut.small_pieces.size(); ++piece) {
        auto file = mesh_file;
        file.replace_filename(fmt::format("{}_piece_{}.msh", mesh_file.stem().string(), piece + 2));
        files.push_back(write_body(file, cut.small_pieces[piece],
                                   fmt::format("A piece that was cut off from {}", cut.body.name), command));
    }
    return files;
}

} // namespace livermark::meshes
