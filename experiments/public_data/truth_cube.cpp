#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <set>
#include <string>

#include "experiments/experiment.hpp"
#include "experiments/marker_table.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "meshes/generators/box_generator.hpp"
#include "support/input_error.hpp"

namespace livermark::experiments::public_data {

namespace {

using core::Vector3;

constexpr int beads_per_side = 7;
constexpr std::size_t num_beads = 343;
constexpr std::size_t num_states = 3;
constexpr std::size_t num_cells = 3 + 3 * (1 + num_states);
constexpr double metres = 1e-3;      ///< per unit of the file
constexpr double side_length = 0.08; ///< of the cube [m]
constexpr double noise = 0.29e-3;    ///< of the displacement of a bead [m]
/// Of the test beside the public file; Young's modulus has no part in where the beads go.
constexpr core::Material silicone{.density = 980.0, .young_modulus = 15.3e3, .poisson_ratio = 0.499};

constexpr const char *load_case = R"(title = "Between two layers of beads that moved as measured"
regime = "large"
path = [0.5, 1.0]
target_peak_displacement = 0.01
[[condition]]
patch = "z_min"
displacement = [0.0, 0.0, 0.0]
[[condition]]
patch = "z_max"
displacement = [0.0, 0.0, 0.0]
)";

Vector3 position(const CsvRow &row, std::size_t state) {
    const std::size_t column = 3 + 3 * state;
    return metres * Vector3(number_in(row, column), number_in(row, column + 1), number_in(row, column + 2));
}

/// The lines of the beads, below those of the header.
std::vector<CsvRow> bead_rows(const std::filesystem::path &file) {
    auto rows = read_csv(file);
    const auto header = std::ranges::find_if(
        rows, [](const CsvRow &row) { return row.cells.size() > 2 && row.cells[0] == "i" && row.cells[2] == "k"; });
    if (header == rows.end())
        throw support::InputError(
            fmt::format("{}: there is no line i,j,k,x0,y0,z0 and so on; take the public file", file.string()));
    rows.erase(rows.begin(), header + 1);
    if (rows.size() != num_beads)
        throw support::InputError(fmt::format("{}: there are {} beads and not {}; take the public file", file.string(),
                                              rows.size(), num_beads));
    return rows;
}

/// The number of a bead in a direction.
int index_in(const CsvRow &row, std::size_t column) {
    const double index = number_in(row, column);
    if (index != std::round(index) || index < 1.0 || index > beads_per_side)
        throw support::InputError(fmt::format("{}: a bead has numbers from 1 to {}, and here is {}; correct the line",
                                              row.place, beads_per_side, index));
    return static_cast<int>(index);
}

Experiment read(const std::filesystem::path &file) {
    Experiment experiment;
    experiment.assumptions = {
        "the body is the silicone between the outermost layers of beads, with free sides 40 mm from the middle bead",
        "both layers move as a polynomial of degree 2 fitted to their 49 beads",
        "Poisson's ratio is 0.499; Young's modulus has no effect"};
    for (const char *name : {"5 %", "12.5 %", "18.25 %"}) // nominal, as the file calls them
        experiment.states.push_back({name, {}, {}, noise});
    std::set<std::array<int, 3>> seen;
    Vector3 middle = Vector3::Zero();
    double bottom = 0.0, top = 0.0;
    for (const auto &row : bead_rows(file)) {
        if (row.cells.size() < num_cells)
            throw support::InputError(fmt::format("{}: the line has {} cells and not {}; correct it", row.place,
                                                  row.cells.size(), num_cells));
        const std::array<int, 3> bead{index_in(row, 0), index_in(row, 1), index_in(row, 2)};
        if (!seen.insert(bead).second)
            throw support::InputError(fmt::format("{}: bead {} {} {} occurs twice; take the public file", row.place,
                                                  bead[0], bead[1], bead[2]));
        const Vector3 rest = position(row, 0);
        const bool is_top = bead[2] == 1, is_bottom = bead[2] == beads_per_side;
        experiment.markers.push_back({fmt::format("{} {} {}", bead[0], bead[1], bead[2]), rest,
                                      is_top      ? "z_max"
                                      : is_bottom ? "z_min"
                                                  : ""});
        for (std::size_t s = 0; s < num_states; ++s)
            experiment.states[s].displacement.emplace_back(position(row, s + 1) - rest);
        constexpr double per_layer = 1.0 / (beads_per_side * beads_per_side);
        middle += rest / static_cast<double>(num_beads);
        top += is_top ? per_layer * rest.z() : 0.0;
        bottom += is_bottom ? per_layer * rest.z() : 0.0;
    }
    const Vector3 corner(middle.x() - 0.5 * side_length, middle.y() - 0.5 * side_length, bottom);
    const Vector3 size(side_length, side_length, top - bottom);
    if (!(size.z() > 0.0))
        throw support::InputError(fmt::format("{}: layer 1 is not above layer 7; take the public file", file.string()));
    experiment.body = [corner, size](double edge_length) {
        core::Body body{.name = "truth_cube",
                        .mesh = meshes::generate_box(size, edge_length, meshes::BoxTopology::body_centred),
                        .materials = {silicone}};
        for (auto &point : body.mesh.points)
            point += corner;
        return body;
    };
    for (auto &state : experiment.states)
        state.load_case = [name = state.name](const core::TetraMesh &mesh) {
            auto made = load_cases::parse_load_case(load_case, "truth_cube.toml", mesh);
            made.name = name;
            return made;
        };
    experiment.edge_length = 0.00925; // bricks of a centimetre
    return experiment;
}

} // namespace

/// 343 beads in a cube of silicone between plates, in a scanner (Kerdok et al. 2003).
PublicExperiment truth_cube() {
    return {.name = {},
            .title = "Truth Cube: beads in a cube of silicone that plates press together",
            .data = "truth_cube/uniaxial_positions.csv",
            .source = "Kerdok et al. 2003, Med. Image Anal. 7(3); SurgSim/Physics/RenderTests/Data/ of "
                      "github.com/simquest/opensurgsim",
            .read = read};
}

} // namespace livermark::experiments::public_data
