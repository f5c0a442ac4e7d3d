#include "msm/statics/conjugate_gradients.hpp"

namespace livermark::msm {

Eigen::VectorXd conjugate_gradients(const LinearMap &matrix, const LinearMap &inverse, const Eigen::VectorXd &b,
                                    double tolerance, int max_steps,
                                    const std::function<void(const Eigen::VectorXd &, const Eigen::VectorXd &)> &see) {
    const double enough = tolerance * b.norm();
    Eigen::VectorXd x = Eigen::VectorXd::Zero(b.size()), residual = b;
    Eigen::VectorXd direction, preconditioned, last_residual;
    double decrease = 0.0;
    for (int step = 0; step < max_steps && residual.norm() > enough; ++step) {
        preconditioned = inverse(residual);
        if (step == 0)
            direction = preconditioned;
        else
            direction = preconditioned + preconditioned.dot(residual - last_residual) / decrease * direction;
        decrease = residual.dot(preconditioned);
        const Eigen::VectorXd image = matrix(direction);
        const double curvature = direction.dot(image);
        if (curvature <= 0.0)
            return step == 0 ? direction : x;
        const double length = decrease / curvature;
        last_residual = residual;
        x += length * direction;
        residual -= length * image;
        if (see)
            see(length * direction, length * image);
    }
    return x;
}

} // namespace livermark::msm
