#include "meshes/generators/expected_tetrahedra.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numbers>

#include "support/input_error.hpp"

namespace livermark::meshes {

double expected_tetrahedra(double side_of_cube, double edge_length) {
    constexpr double per_cube_of_edge = 6.0 * std::numbers::sqrt2;
    return per_cube_of_edge * std::pow(side_of_cube / edge_length, 3);
}

std::string text_of_expected_tetrahedra(double expected) {
    constexpr double most_in_full = 1e12;
    const double unit = std::pow(10.0, std::floor(std::log10(std::max(expected, 1.0))) - 1.0);
    return expected < most_in_full ? fmt::format("about {:.0f} tetrahedra", std::round(expected / unit) * unit)
                                   : fmt::format("about {:.2g} tetrahedra", expected);
}

void check_number_of_tetrahedra(const std::string &what, double side_of_cube, double edge_length) {
    const double expected = expected_tetrahedra(side_of_cube, edge_length);
    if (!(expected <= most_tetrahedra))
        throw support::InputError(
            fmt::format("the edges are too short: {} with edges of {:g} m would have {}, and {:.0f} are the most; make "
                        "them longer, or check that lengths are in metres",
                        what, edge_length, text_of_expected_tetrahedra(expected), most_tetrahedra));
}

} // namespace livermark::meshes
