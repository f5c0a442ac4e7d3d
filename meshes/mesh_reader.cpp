#include "meshes/mesh_reader.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fmt/format.h>
#include <fstream>
#include <string_view>

#include "meshes/msh_reader.hpp"
#include "support/child_process.hpp"
#include "support/input_error.hpp"

namespace livermark::meshes {

namespace {

namespace fs = std::filesystem;

struct Unit {
    std::string_view name;
    double metres;
    double largest_organ; ///< longest side of the bounding box, in the unit
};

constexpr std::array<Unit, 3> units{{{"m", 1.0, 2.0}, {"cm", 1e-2, 60.0}, {"mm", 1e-3, 2000.0}}};

bool is_ascii_msh(const fs::path &file) {
    if (file.extension() != ".msh")
        return false;
    std::ifstream stream(file);
    std::string line, version, is_binary;
    // A file that is damaged here is for the reader of ASCII files, which says where.
    return !(std::getline(stream, line) && stream >> version >> is_binary && is_binary == "1");
}

core::TetraMesh read_converted(const fs::path &file, std::vector<std::string> &remarks) {
    const auto converted = support::convert_by_script(
        "convert_mesh", file,
        "save it as ASCII MSH, VTU, VTK or INP with tetrahedra, and see that python3-meshio is installed");
    remarks.insert(remarks.end(), converted.remarks.begin(), converted.remarks.end());
    return parse_msh(converted.text, file.string() + ", converted");
}

} // namespace

core::TetraMesh read_mesh(const fs::path &file, std::vector<std::string> &remarks) {
    if (!std::ifstream(file))
        throw support::InputError(fmt::format("{}: cannot be read ({}); check the path and who may read it",
                                              file.string(), std::strerror(errno)));
    return is_ascii_msh(file) ? read_msh(file) : read_converted(file, remarks);
}

double metres_per_unit(const std::string &unit, const std::string &place) {
    const auto known = std::ranges::find(units, unit, &Unit::name);
    if (known == units.end())
        throw support::InputError(fmt::format("{}: '{}' is no unit of length here; take m, cm or mm", place, unit));
    return known->metres;
}

std::string guess_unit(const core::TetraMesh &mesh, const std::string &file) {
    Eigen::AlignedBox3d box;
    for (const auto &point : mesh.points)
        box.extend(point);
    const double longest = box.sizes().maxCoeff();
    const auto unit = std::ranges::find_if(units, [&](const Unit &u) { return longest <= u.largest_organ; });
    if (!(longest > 0.0) || unit == units.end())
        throw support::InputError(fmt::format(
            "{}: its longest side is {:g}, which is no organ in m, cm or mm; say which unit it is with 'unit' in a "
            "body .toml",
            file, longest));
    return std::string(unit->name);
}

} // namespace livermark::meshes
