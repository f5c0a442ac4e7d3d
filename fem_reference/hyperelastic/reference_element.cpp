#include "fem_reference/hyperelastic/reference_element.hpp"

#include <cmath>
#include <deal.II/base/quadrature_lib.h>
#include <deal.II/fe/fe_simplex_p.h>

namespace livermark::hyperelastic {

namespace {

/// deal.II's own rule of its order has six points, and other codes have these.
/// (P. C. Hammer, A. H. Stroud 1956, Numerical integration over simplexes, Math. Tables Aids Comput. 10)
dealii::Quadrature<3> four_points() {
    const double near = (5.0 + 3.0 * std::sqrt(5.0)) / 20.0, far = (5.0 - std::sqrt(5.0)) / 20.0;
    return {{{far, far, far}, {near, far, far}, {far, near, far}, {far, far, near}},
            std::vector<double>(4, 1.0 / 24.0)};
}

dealii::Quadrature<3> points_of(TetrahedronRule rule) {
    switch (rule) {
    case TetrahedronRule::one_point:
        return dealii::QGaussSimplex<3>(1);
    case TetrahedronRule::four_points:
        return four_points();
    default:
        return dealii::QWitherdenVincentSimplex<3>(3);
    }
}

/// Gradients of all shape functions at a point, one per column.
template <int dim>
Eigen::Matrix<double, dim, Eigen::Dynamic> gradients_at(const dealii::FE_SimplexP<dim> &element,
                                                        const dealii::Point<dim> &point) {
    Eigen::Matrix<double, dim, Eigen::Dynamic> gradients(dim, element.n_dofs_per_cell());
    for (unsigned int a = 0; a < element.n_dofs_per_cell(); ++a) {
        const auto gradient = element.shape_grad(a, point);
        for (int d = 0; d < dim; ++d)
            gradients(d, a) = gradient[d];
    }
    return gradients;
}

} // namespace

ReferenceTetrahedron reference_tetrahedron(int degree, TetrahedronRule rule) {
    const dealii::FE_SimplexP<3> element(degree), linear(1);
    const auto quadrature = points_of(rule);
    constexpr double volume = 1.0 / 6.0;
    ReferenceTetrahedron result;
    for (unsigned int q = 0; q < quadrature.size(); ++q) {
        const auto &point = quadrature.point(q);
        result.weight.push_back(quadrature.weight(q) / volume);
        result.gradient.push_back(gradients_at(element, point));
        auto &shape = result.linear_shape.emplace_back();
        for (unsigned int k = 0; k < 4; ++k)
            shape[k] = linear.shape_value(k, point);
    }
    return result;
}

ReferenceTriangle reference_triangle(int degree) {
    const dealii::FE_SimplexP<2> element(degree);
    const dealii::QWitherdenVincentSimplex<2> quadrature(3);
    ReferenceTriangle result;
    for (unsigned int q = 0; q < quadrature.size(); ++q) {
        const auto &point = quadrature.point(q);
        result.weight.push_back(quadrature.weight(q));
        result.gradient.push_back(gradients_at(element, point));
        auto &shape = result.shape.emplace_back(element.n_dofs_per_cell());
        for (unsigned int a = 0; a < element.n_dofs_per_cell(); ++a)
            shape[a] = element.shape_value(a, point);
    }
    return result;
}

} // namespace livermark::hyperelastic
