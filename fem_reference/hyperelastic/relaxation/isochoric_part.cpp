#include "fem_reference/hyperelastic/relaxation/isochoric_part.hpp"

#include <Eigen/LU>
#include <cmath>

namespace livermark::hyperelastic {

namespace {

using Vector9 = Eigen::Matrix<double, 9, 1>;

/// In the indices of Tangent.
Vector9 as_vector(const Matrix3 &matrix) {
    Vector9 result;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            result[3 * i + j] = matrix(i, j);
    return result;
}

Matrix3 without_dilation(const Matrix3 &f) {
    return f / std::cbrt(f.determinant());
}

/// Derivative by F' of the energy as a function of F'.
Matrix3 stress_of_shape(const IsochoricPart &part, const Matrix3 &shape) {
    return shape * part.remembered - part.faded * part.law.stress(part.material, shape);
}

} // namespace

double IsochoricPart::energy(const Matrix3 &f) const {
    const Matrix3 shape = without_dilation(f);
    const Matrix3 strain = 0.5 * (shape.transpose() * shape - Matrix3::Identity());
    return remembered.cwiseProduct(strain).sum() - faded * law.energy(material, shape);
}

Matrix3 IsochoricPart::stress(const Matrix3 &f) const {
    const Matrix3 shape = without_dilation(f);
    const Matrix3 of_shape = stress_of_shape(*this, shape);
    const double along = of_shape.cwiseProduct(f).sum();
    return (of_shape - along / 3.0 * Matrix3(f.inverse().transpose())) / std::cbrt(f.determinant());
}

Tangent IsochoricPart::tangent(const Matrix3 &f) const {
    const Matrix3 shape = without_dilation(f), inverse = f.inverse();
    const double scale = 1.0 / std::cbrt(f.determinant());
    Tangent of_shape = -faded * law.tangent(material, shape);
    for (int i = 0; i < 3; ++i)
        of_shape.block<3, 3>(3 * i, 3 * i) += remembered;
    const Matrix3 stress = stress_of_shape(*this, shape);
    const double along = stress.cwiseProduct(f).sum();
    const Vector9 normal = as_vector(inverse.transpose()), stresses = as_vector(stress);
    // dF' = scale (I - F (x) F^-T / 3) dF
    const Tangent map = scale * (Tangent::Identity() - as_vector(f) * normal.transpose() / 3.0);
    Tangent result = map.transpose() * of_shape * map;
    result -= scale / 3.0 * (stresses * normal.transpose() + normal * stresses.transpose());
    result += scale * along / 9.0 * normal * normal.transpose();
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            for (int k = 0; k < 3; ++k)
                for (int l = 0; l < 3; ++l)
                    result(3 * i + j, 3 * k + l) += scale * along / 3.0 * inverse(j, k) * inverse(l, i);
    return result;
}

Matrix3 isochoric_stress(const MaterialLaw &law, const core::Material &material, const Matrix3 &f) {
    const Matrix3 shape = without_dilation(f);
    const Matrix3 stress = shape.inverse() * law.stress(material, shape);
    const Matrix3 c = shape.transpose() * shape;
    const Matrix3 deviator = stress - stress.cwiseProduct(c).sum() / 3.0 * Matrix3(c.inverse());
    return 0.5 * (deviator + deviator.transpose());
}

} // namespace livermark::hyperelastic
