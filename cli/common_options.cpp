#include "cli/common_options.hpp"

namespace livermark::cli {

void add_bodies(CLI::App &command, std::vector<std::string> &bodies) {
    command.add_option("body", bodies,
                       "Names as in 'livermark list bodies', or paths of body .toml files; all that ship if none is "
                       "named");
}

void add_materials(CLI::App &command, meshes::MaterialOverride &material) {
    command.add_option("--young", material.young_modulus,
                       "Young's modulus of the first region [Pa]; the others keep their ratio to it");
    command.add_option("--poisson", material.poisson_ratio, "Poisson's ratio of every region");
}

} // namespace livermark::cli
