#include "fem_reference/hyperelastic/material_law.hpp"

#include <algorithm>
#include <stdexcept>

namespace livermark::hyperelastic {

const MaterialLaw &material_law(const std::string &name) {
    const auto laws = all_materials();
    const auto found = std::ranges::find(laws, name, &MaterialLaw::name);
    if (found != laws.end())
        return *found;
    std::string names;
    for (const auto &law : laws)
        names += (names.empty() ? "" : ", ") + law.name;
    throw std::invalid_argument("there is no hyperelastic material " + name + "; choose one of " + names);
}

void add_volume_tangent(double factor, double outer, double jacobian, const Matrix3 &inverse, Tangent &tangent) {
    // d J / d F_iJ = J G_Ji
    const double of_products = factor * jacobian + outer * jacobian * jacobian;
    const double of_swapped = -factor * jacobian;
    for (int i = 0; i < 3; ++i)
        for (int big_j = 0; big_j < 3; ++big_j)
            for (int j = 0; j < 3; ++j)
                for (int big_l = 0; big_l < 3; ++big_l)
                    tangent(3 * i + big_j, 3 * j + big_l) += of_products * inverse(big_j, i) * inverse(big_l, j) +
                                                             of_swapped * inverse(big_l, i) * inverse(big_j, j);
}

} // namespace livermark::hyperelastic
