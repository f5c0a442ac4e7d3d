#include "msm/statics/free_components.hpp"

#include <cmath>

namespace livermark::msm {

FreeComponents::FreeComponents(const std::vector<core::Vector3> &prescribed) {
    number_.reserve(3 * prescribed.size());
    for (const auto &node : prescribed)
        for (int component = 0; component < 3; ++component)
            number_.push_back(std::isnan(node[component]) ? size_++ : -1);
}

std::vector<bool> FreeComponents::are_free() const {
    std::vector<bool> free;
    free.reserve(number_.size());
    for (const auto number : number_)
        free.push_back(number >= 0);
    return free;
}

Eigen::VectorXd FreeComponents::gather(const std::vector<core::Vector3> &field) const {
    Eigen::VectorXd values(size_);
    for (std::size_t c = 0; c < number_.size(); ++c)
        if (number_[c] >= 0)
            values[number_[c]] = field[c / 3][static_cast<Eigen::Index>(c % 3)];
    return values;
}

void FreeComponents::add(std::vector<core::Vector3> &field, const Eigen::VectorXd &values, double scale) const {
    for (std::size_t c = 0; c < number_.size(); ++c)
        if (number_[c] >= 0)
            field[c / 3][static_cast<Eigen::Index>(c % 3)] += scale * values[number_[c]];
}

Eigen::SparseMatrix<double> FreeComponents::restrict(const Eigen::SparseMatrix<double> &matrix) const {
    // Free components are in the order of all, so entries come as a compressed matrix keeps them.
    Eigen::SparseMatrix<double> restricted(size_, size_);
    restricted.reserve(matrix.nonZeros());
    for (Eigen::Index column = 0; column < matrix.outerSize(); ++column) {
        if (!is_free(column))
            continue;
        restricted.startVec(number_[column]);
        for (Eigen::SparseMatrix<double>::InnerIterator entry(matrix, column); entry; ++entry)
            if (is_free(entry.row()))
                restricted.insertBackByOuterInner(number_[column], number_[entry.row()]) = entry.value();
    }
    restricted.finalize();
    return restricted;
}

Eigen::VectorXd inverse_root_mass(const std::vector<double> &node_mass, const FreeComponents &free) {
    std::vector<core::Vector3> root;
    root.reserve(node_mass.size());
    for (const double mass : node_mass)
        root.emplace_back(core::Vector3::Constant(1.0 / std::sqrt(mass)));
    return free.gather(root);
}

} // namespace livermark::msm
