#include "meshes/io/mesh_reader.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <fstream>
#include <sstream>
#include <string_view>

#include "core/mesh/bounding_box.hpp"
#include "core/mesh/plausible_liver.hpp"
#include "meshes/io/msh_reader.hpp"
#include "support/file_ending.hpp"
#include "support/input_error.hpp"
#include "support/length_unit.hpp"
#include "support/processes/child_process.hpp"
#include "support/toml_input.hpp"
#include "support/whole_file.hpp"

namespace livermark::meshes {

namespace {

namespace fs = std::filesystem;

/// Longest side of an organ's bounding box, in each of support::length_units.
constexpr std::array<double, support::length_units.size()> longest_organ{core::largest_organ, 60.0, 2000.0};

bool is_ascii_msh(const fs::path &file) {
    if (support::file_ending(file) != ".msh")
        return false;
    // Comments may come before the format. A file that is damaged here is for the reader of ASCII files, which says
    // where.
    std::string start(4096, '\0'), version, is_binary;
    std::ifstream stream(file, std::ios::binary);
    stream.read(start.data(), static_cast<std::streamsize>(start.size()));
    const auto format = start.find("$MeshFormat");
    if (format == std::string::npos)
        return true;
    std::istringstream words(start.substr(format));
    words >> version >> version >> is_binary;
    return is_binary != "1";
}

core::TetraMesh read_converted(const fs::path &file, std::vector<std::string> &remarks) {
    const auto converted = support::convert_by_script(
        "convert_mesh", file,
        "save it as ASCII MSH, VTU, VTK or INP with tetrahedra, and check that python3-meshio is installed");
    remarks.insert(remarks.end(), converted.remarks.begin(), converted.remarks.end());
    return parse_msh(converted.text, file.string(), &remarks);
}

/// Files that come from a segmentation and never hold tetrahedra.
void refuse_segmentation(const fs::path &file) {
    constexpr std::array<std::string_view, 7> images{".nii", ".nii.gz", ".nrrd", ".nhdr", ".mha", ".mhd", ".dcm"};
    constexpr std::array<std::string_view, 4> surfaces{".stl", ".obj", ".ply", ".off"};
    const auto name = support::lower_case(file.filename().string());
    const auto ends_so = [&](std::string_view ending) { return name.ends_with(ending); };
    const bool is_image = std::ranges::any_of(images, ends_so);
    if (is_image || std::ranges::any_of(surfaces, ends_so))
        throw support::InputError(fmt::format(
            "{}: this is {}, not a mesh of tetrahedra; make a body of it with `livermark mesh {} {} -o body.msh`",
            file.string(), is_image ? "an image" : "a surface", is_image ? "--labels" : "--surfaces",
            file.filename().string()));
}

} // namespace

core::TetraMesh read_mesh(const fs::path &file, std::vector<std::string> &remarks) {
    support::check_readable(file);
    refuse_segmentation(file);
    return is_ascii_msh(file) ? read_msh(file, &remarks) : read_converted(file, remarks);
}

UnitGuess guess_unit(const std::vector<core::Vector3> &points, double volume, const std::string &file) {
    const double longest = core::bounding_box(points).sizes().maxCoeff();
    const auto unit =
        static_cast<std::size_t>(std::ranges::lower_bound(longest_organ, longest) - longest_organ.begin());
    if (!(longest > 0.0) || unit == longest_organ.size())
        throw support::InputError(
            fmt::format("{}: its longest side is {:g}, which fits no organ in m, cm or mm; set 'unit' in a body .toml",
                        file, longest));
    const auto &[name, metres] = support::length_units[unit];
    const double litres = 1e3 * volume * metres * metres * metres;
    UnitGuess guess{std::string(name), metres, {}};
    const auto by_length = fmt::format("from its longest side, which is then {:.3g} cm", 1e2 * longest * metres);
    if (litres >= core::smallest_liver && litres <= core::largest_liver)
        guess.remark = fmt::format("{}, and its volume, which is then {:.3g} L", by_length, litres);
    else
        guess.remark = fmt::format(
            "{}; but its volume is then {:.2g} L, where an adult liver has {} to {} L, and a unit of {:.2g} m "
            "would make it {} L",
            by_length, litres, core::smallest_liver, core::largest_liver, std::cbrt(1e-3 * core::usual_liver / volume),
            core::usual_liver);
    return guess;
}

} // namespace livermark::meshes
