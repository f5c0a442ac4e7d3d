#include "tests/app/cli/bad_inputs/bad_inputs.hpp"

#include <fstream>
#include <regex>
#include <sstream>
#include <stdexcept>

#include "meshes/io/mesh_files.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::tests {

namespace fs = std::filesystem;

const std::string good_msh = R"($MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
2
2 1 "base"
3 1 "solid"
$EndPhysicalNames
$Nodes
5
1 0 0 0
2 1 0 0
3 0 1 0
4 0 0 1
5 1 1 1
$EndNodes
$Elements
3
1 2 2 1 1 1 3 2
2 4 2 1 1 1 2 3 4
3 4 2 1 1 2 3 4 5
$EndElements
)";

const std::string good_body = R"(title = "bar"
mesh = "bar.msh"
[regions.solid]
density = 1000.0
young_modulus = 5000.0
poisson_ratio = 0.3
source = "made up"
)";

const std::string good_case = R"(title = "pull"
target_peak_displacement = 0.001
[[condition]]
patch = "x_min"
displacement = [0.0, 0.0, 0.0]
[[condition]]
patch = "x_max"
traction = [10.0, 0.0, 0.0]
)";

const std::string good_release = good_case + R"([release]
duration = 1.0
output_interval = 0.1
damping_ratio = 0.05
damping_frequencies = [2.0, 10.0]
[[probe]]
name = "end"
patch = "x_max"
)";

const std::string good_run = "run --body bar.toml --load-case case.toml --model lloyd --reference-on-mesh --output out";

void write_bar(const fs::path &folder) {
    if (!fs::exists(folder / "bar.toml"))
        std::ofstream(folder / "bar.toml") << good_body;
    meshes::write_msh(folder / "bar.msh", box_mesh({0.09, 0.03, 0.03}, {3, 1, 1}));
    fs::create_directories(folder / "out" / "bar");
    std::ofstream(folder / "out" / "bar" / "case.h5") << "an earlier result";
}

std::string replaced(std::string text, const std::string &from, const std::string &to) {
    const auto at = text.find(from);
    if (at == std::string::npos)
        throw std::invalid_argument("'" + from + "' is not there to be replaced");
    return text.replace(at, from.size(), to);
}

std::string random_bytes() {
    std::string bytes;
    for (std::uint32_t state = 1; bytes.size() < 600; state = 1664525 * state + 1013904223)
        bytes += static_cast<char>(state >> 24);
    return bytes;
}

Files files_below(const fs::path &folder) {
    Files found;
    for (auto entry = fs::recursive_directory_iterator(folder); entry != fs::recursive_directory_iterator(); ++entry) {
        // A run keeps what it has solved for --resume, whatever stops it.
        if (entry->path().filename() == ".solutions")
            entry.disable_recursion_pending();
        else
            found[fs::relative(entry->path(), folder)] = entry->is_regular_file() ? entry->file_size() : 0;
    }
    return found;
}

Files prepare_bad_input(const BadInput &row, const fs::path &folder) {
    for (const auto &[name, text] : row.files)
        std::ofstream(folder / name, std::ios::binary) << text;
    if (row.prepare)
        row.prepare(folder);
    return files_below(folder);
}

ChildEnd try_bad_input(const BadInput &row, const fs::path &folder) {
    std::vector<std::string> words{LIVERMARK_BINARY};
    std::istringstream arguments(row.arguments);
    for (std::string word; arguments >> word;)
        words.push_back(word);
    auto how = row.how;
    how.folder = folder;
    return run_child(words, how);
}

std::vector<std::string> message_lines(const std::string &errors) {
    std::vector<std::string> lines;
    std::istringstream stream(errors);
    for (std::string line; std::getline(stream, line);)
        if (!line.starts_with('['))
            lines.push_back(line);
    return lines;
}

std::string as_documented(const std::string &line, const fs::path &folder) {
    std::string text = line.substr(line.find(": ") + 2);
    const auto place = folder.string() + "/";
    for (auto at = text.find(place); at != std::string::npos; at = text.find(place))
        text.erase(at, place.size());
    static const std::regex number("(cannot write |prints the |s, and )[0-9]+( bytes| that are known| are such)");
    return std::regex_replace(text, number, "$1N$2");
}

std::vector<BadInputGroup> all_bad_inputs() {
    return {{"Meshes (`.msh`)", bad_meshes()},
            {"Bodies (`.toml`, and meshes of other formats)", bad_bodies()},
            {"Load cases (`.toml`)", bad_load_cases()},
            {"Load cases with a release", bad_releases()},
            {"Load cases with a cut", bad_cuts()},
            {"Blades that go into a body (`livermark cut`)", bad_blades()},
            {"Load cases in which time passes in the material", bad_histories()},
            {"Load cases with a ball that touches", bad_touches()},
            {"Load cases with an elastic foundation", bad_foundations()},
            {"Result and calibration files (`.h5`)", bad_hdf5_files()},
            {"Label images and surfaces (`livermark mesh --labels`, `--surfaces`)", bad_images()},
            {"Solutions of other models (`livermark score`)", bad_solutions()},
            {"Command lines", bad_command_lines()},
            {"Files and places without permission or room", bad_places()}};
}

} // namespace livermark::tests
