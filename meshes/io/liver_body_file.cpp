#include "meshes/io/liver_body_file.hpp"

#include <fmt/format.h>

#include "meshes/io/msh_writer.hpp"
#include "support/input_error.hpp"
#include "support/whole_file.hpp"

namespace livermark::meshes {

void write_liver_body(const std::filesystem::path &mesh_file, const core::TetraMesh &mesh, const LiverVariant &variant,
                      const std::string &command) {
    if (mesh_file.extension() != ".msh")
        throw support::InputError(
            fmt::format("{}: the mesh is written as MSH; end its name in .msh", mesh_file.string()));
    auto text = fmt::format("# Axes: x to the patient's left, y posterior, z superior (LPS) [m].\n"
                            "title = \"Liver of {:.2f} L, {} lesions\"\nmesh = '{}'\ngenerator = '{}'\n",
                            1e3 * variant.volume, variant.lesions.size(), mesh_file.filename().string(), command);
    for (const auto &name : mesh.region_names)
        text += fmt::format("\n[regions.{}]\ndensity = 1060.0        # kg/m^3\nyoung_modulus = {} # Pa\n"
                            "poisson_ratio = 0.45\nsource = \"as of the livers that ship\"\n",
                            name, name == "parenchyma" ? "5000.0" : "50000.0");
    write_msh(mesh_file, mesh);
    auto body_file = mesh_file;
    support::write_whole(body_file.replace_extension(".toml"), text);
}

} // namespace livermark::meshes
