#include "msm/statics/compliance.hpp"

#include <cmath>
#include <fmt/format.h>

#include "msm/nodal_conditions.hpp"
#include "msm/statics/rest_stiffness.hpp"
#include "support/input_error.hpp"

namespace livermark::msm {

core::Compliance compliance(const ElasticBody &body, const core::Problem &problem,
                            std::span<const core::InteriorPlace> places) {
    const auto &mesh = problem.body->mesh;
    auto held = nodal_conditions(problem, body.node_mass).displacement;
    for (auto &of_node : held)
        for (double &value : of_node)
            value = std::isnan(value) ? value : 0.0;
    const RestStiffness rest(body, mesh.points, held);
    if (!rest.is_definite())
        throw support::InputError(fmt::format("{}: load case '{}' leaves the body free to move, or its springs do not "
                                              "hold it up; constrain it, or leave this model out",
                                              problem.body->name, problem.load_case.name));
    const auto weights = core::nodal_weights(places, mesh);
    core::Compliance found;
    found.degrees_of_freedom = 3 * static_cast<std::int64_t>(mesh.points.size());
    found.matrix.resize(3 * weights.rows(), 3 * weights.rows());
    for (Eigen::Index column = 0; column < found.matrix.cols(); ++column) {
        std::vector<core::Vector3> force(mesh.points.size(), core::Vector3::Zero());
        for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator entry(weights, column / 3); entry; ++entry)
            force[entry.col()][column % 3] = entry.value();
        const auto displacement = rest.solve(held, force);
        for (Eigen::Index place = 0; place < weights.rows(); ++place) {
            core::Vector3 mean = core::Vector3::Zero();
            for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator entry(weights, place); entry; ++entry)
                mean += entry.value() * displacement[entry.col()];
            found.matrix.col(column).segment<3>(3 * place) = mean;
        }
    }
    return found;
}

} // namespace livermark::msm
