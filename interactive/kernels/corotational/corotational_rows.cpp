#include "interactive/kernels/corotational/corotational_rows.hpp"

#include <Eigen/Geometry>
#include <algorithm>

#include "interactive/elements/energies.hpp"

namespace livermark::interactive::kernels {

CorotationalRows corotational_rows(const Scene &scene) {
    CorotationalRows rows;
    rows.body = explicit_rows(scene, Pressure::of_tetrahedra);
    rows.turned = rows.body.tetrahedra;
    const std::size_t num_lines = rows.body.line_start.back();
    rows.rotation.assign(num_lines * numbers_of_rotation * slice_size, 0.0F);
    for (std::size_t line = 0; line < num_lines; ++line)
        std::fill_n(rows.rotation.begin() + static_cast<std::ptrdiff_t>(line * numbers_of_rotation * slice_size),
                    slice_size, 1.0F);
    for (auto &slots : rows.block_slots)
        slots.assign(rows.body.force.size(), 0.0F);
    for (auto *field : {&rows.block[0], &rows.block[1], &rows.mass, &rows.residual, &rows.direction, &rows.product,
                        &rows.preconditioned})
        field->assign(4 * rows.body.num_rows, 0.0F);
    rows.inverse_block.assign(6 * rows.body.num_rows, 0.0F);

    std::vector<double> laplacian(scene.node_mass.size(), 0.0);
    for (const auto &t : tetrahedra_at_rest(*scene.body)) {
        const auto gradients = t.shape_gradients();
        for (int c = 0; c < 4; ++c)
            laplacian[t.nodes[c]] += t.volume * t.mu * gradients.row(c).squaredNorm();
    }
    for (std::size_t row = 0; row < rows.body.num_rows; ++row) // what fills up has some mass
        std::fill_n(rows.mass.begin() + static_cast<std::ptrdiff_t>(4 * row), 3, 1.0F);
    for (std::size_t i = 0; i < laplacian.size(); ++i) {
        const auto at = rows.mass.begin() + std::ptrdiff_t{4} * rows.body.row_of_node[i];
        std::fill_n(at, 3, static_cast<float>(scene.node_mass[i]));
        at[3] = static_cast<float>(laplacian[i]);
    }
    return rows;
}

std::size_t CorotationalRows::bytes() const {
    return body.bytes() + bytes_of(turned, rotation, block_slots[0], block_slots[1], block[0], block[1], mass, residual,
                                   direction, product, preconditioned, inverse_block);
}

void find_nearest_rotation(const std::array<float, 9> &h, std::array<float, 4> &q) {
    const Matrix3 f = Eigen::Map<const Eigen::Matrix3f>(h.data()).cast<double>() + Matrix3::Identity();
    if (!f.allFinite())
        return;
    const Eigen::Quaterniond found(densities::nearest_rotation(f));
    q = {static_cast<float>(found.w()), static_cast<float>(found.x()), static_cast<float>(found.y()),
         static_cast<float>(found.z())};
}

} // namespace livermark::interactive::kernels
