#include "meshes/mesh_reader.hpp"

#include <array>
#include <cerrno>
#include <cstring>
#include <fmt/format.h>
#include <fstream>

#include "core/child_process.hpp"
#include "core/input_error.hpp"
#include "core/root_folder.hpp"
#include "core/toml_input.hpp"
#include "meshes/msh_reader.hpp"

namespace livermark::meshes {

namespace {

namespace fs = std::filesystem;

bool is_ascii_msh(const fs::path &file) {
    if (file.extension() != ".msh")
        return false;
    std::ifstream stream(file);
    std::string line, version, is_binary;
    // A file that is damaged here is for the reader of ASCII files, which says where.
    return !(std::getline(stream, line) && stream >> version >> is_binary && is_binary == "1");
}

core::TetraMesh read_converted(const fs::path &file, std::vector<std::string> &remarks) {
    const core::ScratchFolder scratch;
    const auto converted = scratch.path / "converted.msh";
    const auto script = core::root_folder() / "scripts" / "convert_mesh";
    const auto [status, lines] = core::run_program({script.string(), fs::absolute(file).string(), converted.string()});
    if (status != 0)
        throw core::InputError(fmt::format("{}: cannot be converted ({}); save it as ASCII MSH, VTU, VTK or INP with "
                                           "tetrahedra, and see that python3-meshio is installed",
                                           file.string(), lines.empty() ? "no reason given" : lines.back()));
    remarks.insert(remarks.end(), lines.begin(), lines.end());
    return parse_msh(core::read_text(converted), file.string() + ", converted");
}

} // namespace

core::TetraMesh read_mesh(const fs::path &file, std::vector<std::string> &remarks) {
    if (!std::ifstream(file))
        throw core::InputError(fmt::format("{}: cannot be read ({}); check the path and who may read it", file.string(),
                                           std::strerror(errno)));
    return is_ascii_msh(file) ? read_msh(file) : read_converted(file, remarks);
}

double metres_per_unit(const std::string &unit, const std::string &place) {
    if (unit == "m")
        return 1.0;
    if (unit == "cm")
        return 1e-2;
    if (unit == "mm")
        return 1e-3;
    throw core::InputError(fmt::format("{}: '{}' is no unit of length here; take m, cm or mm", place, unit));
}

std::string guess_unit(const core::TetraMesh &mesh, const std::string &file) {
    Eigen::AlignedBox3d box;
    for (const auto &point : mesh.points)
        box.extend(point);
    const double longest = box.sizes().maxCoeff();
    struct Guess {
        double largest;
        const char *unit;
    };
    for (const auto &[largest, unit] : std::array<Guess, 3>{{{2.0, "m"}, {60.0, "cm"}, {2000.0, "mm"}}})
        if (longest > 0.0 && longest <= largest)
            return unit;
    throw core::InputError(fmt::format(
        "{}: its longest side is {:g}, which is no organ in m, cm or mm; say which unit it is", file, longest));
}

} // namespace livermark::meshes
