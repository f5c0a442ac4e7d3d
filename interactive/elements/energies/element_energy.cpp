#include "interactive/elements/energies/element_energy.hpp"

namespace livermark::interactive {

void add_tangent(const Tetrahedron &tetrahedron, const densities::Tangent &tangent, Energy::Triplets &triplets) {
    const auto gradients = tetrahedron.shape_gradients();
    for (int a = 0; a < 4; ++a)
        for (int b = 0; b < 4; ++b) {
            Matrix3 block = Matrix3::Zero();
            for (int j = 0; j < 3; ++j)
                for (int l = 0; l < 3; ++l)
                    block += gradients(a, j) * gradients(b, l) * tangent.block<3, 3>(3 * j, 3 * l);
            block *= tetrahedron.volume;
            for (int i = 0; i < 3; ++i)
                for (int k = 0; k < 3; ++k)
                    triplets.emplace_back(3 * tetrahedron.nodes[a] + i, 3 * tetrahedron.nodes[b] + k, block(i, k));
        }
}

} // namespace livermark::interactive
