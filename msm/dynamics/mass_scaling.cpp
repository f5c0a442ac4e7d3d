#include "msm/dynamics/time_step.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace livermark::msm {

namespace {

/// Least ratio of squared speeds of sound: steps get shorter by the root of it.
constexpr double least_contrast = 2.0;
/// As few nodes do not deform.
constexpr std::size_t least_nodes = 4;
/// Part of omega_rest: deformations above it would take a part of the step away when they are left alone.
constexpr double slow_part = 0.9;
/// Tolerance of squared frequencies, where a factor is found from them: what a step comes to is looked at afterwards.
constexpr double factor_tolerance = 1e-4;
/// Part of the length of a field: with no more besides what is in others it is a sum of them.
constexpr double smallest_field = 1e-6;

double squared_speed(const core::Material &material) {
    return (material.lame_lambda() + 2.0 * material.shear_modulus()) / material.density;
}

/// (R) whether a region is stiffer than the largest one.
std::vector<bool> stiff_regions(const core::Body &body) {
    std::vector<double> volume(body.materials.size(), 0.0);
    const auto volumes = core::tetrahedron_volumes(body.mesh);
    for (std::size_t t = 0; t < volumes.size(); ++t)
        volume[body.mesh.region[t]] += volumes[t];
    const auto largest = std::ranges::max_element(volume) - volume.begin();
    std::vector<bool> are_stiff;
    for (const auto &material : body.materials)
        are_stiff.push_back(squared_speed(material) > least_contrast * squared_speed(body.materials[largest]));
    return are_stiff;
}

/// The same body with the other nodes constrained as well.
NodalConditions with_these_free(NodalConditions conditions, const std::vector<bool> &are_free) {
    for (std::size_t i = 0; i < are_free.size(); ++i)
        if (!are_free[i])
            conditions.displacement[i].setZero();
    return conditions;
}

/// Places of nodes, as far as rigid motions need them.
struct Frame {
    Eigen::Vector3d centre;
    Eigen::Matrix3d inverse_inertia;
};

Frame frame_of(const Eigen::VectorXd &mass, const Eigen::Matrix3Xd &x) {
    const Eigen::Vector3d centre = x * mass / mass.sum();
    const Eigen::Matrix3Xd arm = x.colwise() - centre;
    const Eigen::Matrix3d second = arm * mass.asDiagonal() * arm.transpose(); // moments
    const Eigen::Matrix3d inertia = second.trace() * Eigen::Matrix3d::Identity() - second;
    return {centre, inertia.inverse()};
}

struct RigidMotion {
    Eigen::Vector3d centre, velocity, rotation; ///< velocity of the centre of mass, angular velocity

    Eigen::Vector3d at(const Eigen::Vector3d &x) const { return velocity + rotation.cross(x - centre); }
};

/// At x, that with the momentum and angular momentum of a field.
RigidMotion fitted_motion(const Frame &frame, const Eigen::VectorXd &mass, const Eigen::Matrix3Xd &x,
                          const Eigen::Matrix3Xd &field) {
    Eigen::Vector3d momentum = Eigen::Vector3d::Zero(), spin = momentum; // about the centre
    for (Eigen::Index i = 0; i < x.cols(); ++i) {
        const Eigen::Vector3d weighted = mass[i] * field.col(i);
        momentum += weighted;
        spin += (x.col(i) - frame.centre).cross(weighted);
    }
    return {frame.centre, momentum / mass.sum(), frame.inverse_inertia * spin};
}

Eigen::Matrix3Xd rigid_motion(const Frame &frame, const Eigen::VectorXd &mass, const Eigen::Matrix3Xd &x,
                              const Eigen::Matrix3Xd &field) {
    const auto motion = fitted_motion(frame, mass, x, field);
    Eigen::Matrix3Xd rigid(3, x.cols());
    for (Eigen::Index i = 0; i < x.cols(); ++i)
        rigid.col(i) = motion.at(x.col(i));
    return rigid;
}

/// The centripetal and Coriolis accelerations of a part that turns: what its nodes are accelerated by although, seen
/// from the part, they are not.
Eigen::Matrix3Xd turning(const Frame &frame, const ScaledRegion &part, const Eigen::Matrix3Xd &x,
                         const Eigen::Matrix3Xd &v) {
    const auto motion = fitted_motion(frame, part.mass, x, v);
    Eigen::Matrix3Xd acceleration(3, x.cols());
    for (Eigen::Index i = 0; i < x.cols(); ++i) {
        const Eigen::Vector3d rigid = motion.rotation.cross(x.col(i) - motion.centre);
        const Eigen::Vector3d relative = v.col(i) - motion.velocity - rigid;
        acceleration.col(i) = motion.rotation.cross(rigid + 2.0 * relative);
    }
    return acceleration;
}

Eigen::Matrix3Xd gathered(const ScaledRegion &part, const Eigen::VectorXd &field) {
    Eigen::Matrix3Xd part_values(3, static_cast<Eigen::Index>(part.nodes.size()));
    for (Eigen::Index i = 0; i < part_values.cols(); ++i)
        part_values.col(i) = node_part(field, part.nodes[i]);
    return part_values;
}

void scatter(const ScaledRegion &part, const Eigen::Matrix3Xd &part_values, Eigen::VectorXd &field) {
    for (Eigen::Index i = 0; i < part_values.cols(); ++i)
        node_part(field, part.nodes[i]) = part_values.col(i);
}

auto as_vector(const Eigen::Matrix3Xd &field) {
    return Eigen::VectorXd::Map(field.data(), field.size());
}

void scale_in(const Frame &frame, const ScaledRegion &part, const Eigen::Matrix3Xd &x, double factor,
              Eigen::Matrix3Xd &field) {
    Eigen::Matrix3Xd left_alone = rigid_motion(frame, part.mass, x, field);
    if (part.slow.cols() > 0) {
        const Eigen::Matrix3d turn = nearest_rotation(x * part.mass.asDiagonal() * part.rest.transpose());
        const Eigen::Matrix3Xd weighted = turn.transpose() * (field - left_alone) * part.mass.asDiagonal();
        const Eigen::VectorXd slow = part.slow * (part.slow.transpose() * as_vector(weighted));
        const Eigen::Matrix3Xd deforming = turn * Eigen::Matrix3Xd::Map(slow.data(), 3, x.cols());
        // A part that is not as at rest has rigid motion in this, too.
        left_alone += deforming - rigid_motion(frame, part.mass, x, deforming);
    }
    field = left_alone + factor * (field - left_alone);
}

/// By Gram and Schmidt's method, twice, column by column: the same bits on every machine, which products of matrices in
/// blocks that fit the caches do not have. Columns that are sums of others are left out.
Eigen::MatrixXd orthonormal(const Eigen::MatrixXd &columns) {
    Eigen::MatrixXd found(columns.rows(), columns.cols());
    Eigen::Index count = 0;
    for (Eigen::Index p = 0; p < columns.cols(); ++p) {
        Eigen::VectorXd column = columns.col(p);
        const double length = column.norm();
        for (int pass = 0; pass < 2; ++pass)
            for (Eigen::Index q = 0; q < count; ++q)
                column -= found.col(q).dot(column) * found.col(q);
        if (column.norm() > smallest_field * length)
            found.col(count++) = column.normalized();
    }
    return found.leftCols(count);
}

/// (3n, m) linear and quadratic fields of a part without their rigid motion, times the roots of the masses,
/// orthonormal.
Eigen::MatrixXd polynomial_fields(const ScaledRegion &part, const Eigen::VectorXd &root_mass) {
    const auto &y = part.rest;
    const auto at_rest = frame_of(part.mass, y);
    const double size = y.cwiseAbs().maxCoeff();
    std::vector<Eigen::RowVectorXd> polynomials;
    for (int a = 0; a < 3; ++a) {
        polynomials.emplace_back(y.row(a) / size);
        for (int b = a; b < 3; ++b)
            polynomials.emplace_back(y.row(a).cwiseProduct(y.row(b)) / (size * size));
    }
    Eigen::MatrixXd fields(y.size(), 3 * static_cast<Eigen::Index>(polynomials.size()));
    for (Eigen::Index p = 0; p < fields.cols(); ++p) {
        Eigen::Matrix3Xd field = Eigen::Matrix3Xd::Zero(3, y.cols());
        field.row(p % 3) = polynomials[p / 3];
        field -= rigid_motion(at_rest, part.mass, y, field);
        fields.col(p) = root_mass.cwiseProduct(as_vector(field));
    }
    return orthonormal(fields);
}

/// Slow fields among them, by Ritz's method with the rest of the body at rest.
Eigen::MatrixXd slow_fields(const ScaledRegion &part, const StiffnessProduct &stiffness, Eigen::Index num_unknowns,
                            double highest) {
    const Eigen::VectorXd root_mass = as_vector(part.mass.cwiseSqrt().transpose().replicate(3, 1));
    const Eigen::MatrixXd fields = root_mass.cwiseInverse().asDiagonal() * polynomial_fields(part, root_mass);
    Eigen::MatrixXd forces(fields.rows(), fields.cols());
    for (Eigen::Index p = 0; p < fields.cols(); ++p) {
        Eigen::VectorXd displacement = Eigen::VectorXd::Zero(num_unknowns);
        for (std::size_t i = 0; i < part.nodes.size(); ++i)
            node_part(displacement, part.nodes[i]) = fields.col(p).segment<3>(3 * static_cast<Eigen::Index>(i));
        const Eigen::VectorXd force = stiffness.times(displacement);
        for (std::size_t i = 0; i < part.nodes.size(); ++i)
            forces.col(p).segment<3>(3 * static_cast<Eigen::Index>(i)) = node_part(force, part.nodes[i]);
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> ritz(
        fields.transpose().lazyProduct(forces).eval()); // ascending; summed in one order, see orthonormal()
    const auto count = (ritz.eigenvalues().array() < highest * highest).count();
    return fields.lazyProduct(ritz.eigenvectors().leftCols(count));
}

} // namespace

Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d &moment) {
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(moment, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Matrix3d left = svd.matrixU();
    left.col(2) *= (left * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
    return left * svd.matrixV().transpose();
}

std::vector<std::vector<int>> stiff_parts(const core::Body &body) {
    const auto are_stiff = stiff_regions(body);
    std::vector<int> parent(body.mesh.points.size());
    std::iota(parent.begin(), parent.end(), 0);
    const auto root = [&](int node) {
        while (parent[node] != node)
            node = parent[node] = parent[parent[node]];
        return node;
    };
    std::vector<bool> is_member(parent.size(), false);
    for (std::size_t t = 0; t < body.mesh.tetrahedra.size(); ++t)
        if (are_stiff[body.mesh.region[t]])
            for (const int node : body.mesh.tetrahedra[t]) {
                is_member[node] = true;
                parent[root(node)] = root(body.mesh.tetrahedra[t][0]);
            }
    std::map<int, std::vector<int>> nodes_of_root;
    for (std::size_t i = 0; i < parent.size(); ++i)
        if (is_member[i])
            nodes_of_root[root(static_cast<int>(i))].push_back(static_cast<int>(i));
    std::vector<std::vector<int>> parts;
    for (auto &[root_number, nodes] : nodes_of_root)
        parts.push_back(std::move(nodes));
    std::ranges::sort(parts);
    return parts;
}

MassScaling constrained(const MassScaling &scaling, const NodalConditions &conditions) {
    MassScaling result;
    for (const auto &part : scaling.parts) {
        std::vector<int> free;
        std::vector<Eigen::Index> columns;
        for (std::size_t i = 0; i < part.nodes.size(); ++i)
            if (conditions.displacement[part.nodes[i]].array().isNaN().all()) {
                free.push_back(part.nodes[i]);
                columns.push_back(static_cast<Eigen::Index>(i));
            }
        if (free.size() == part.nodes.size())
            result.parts.push_back(part);
        else if (free.size() >= least_nodes) {
            ScaledRegion less{free, part.factor, part.mass(columns), part.rest(Eigen::all, columns), {}};
            less.rest.colwise() -= Eigen::Vector3d(less.rest * less.mass / less.mass.sum());
            result.parts.push_back(std::move(less));
        }
    }
    return result;
}

MassScaling scale_masses(const core::Body &body, const ElasticBody &springs, const NodalConditions &conditions) {
    const auto &points = body.mesh.points;
    MassScaling scaling;
    for (auto &nodes : stiff_parts(body)) {
        const auto size = static_cast<Eigen::Index>(nodes.size());
        ScaledRegion part{std::move(nodes), 1.0, Eigen::VectorXd(size), Eigen::Matrix3Xd(3, size), {}};
        for (Eigen::Index i = 0; i < size; ++i) {
            part.mass[i] = springs.node_mass[part.nodes[i]];
            part.rest.col(i) = points[part.nodes[i]];
        }
        part.rest.colwise() -= Eigen::Vector3d(part.rest * part.mass / part.mass.sum());
        scaling.parts.push_back(std::move(part));
    }
    scaling = constrained(scaling, conditions);
    std::vector<bool> is_rest(points.size(), true);
    for (const auto &part : scaling.parts)
        for (const int node : part.nodes)
            is_rest[node] = false;
    const double rest_frequency =
        scaling.parts.empty()
            ? 0.0
            : largest_angular_frequency(springs, points, with_these_free(conditions, is_rest), {}, factor_tolerance);
    if (!(rest_frequency > 0.0))
        return {}; // no tissue to be as slow as
    const StiffnessProduct stiffness(springs, points);
    for (auto &part : scaling.parts) {
        std::vector<bool> is_free(points.size(), false);
        for (const int node : part.nodes)
            is_free[node] = true;
        const double frequency =
            largest_angular_frequency(springs, points, with_these_free(conditions, is_free), {}, factor_tolerance);
        // The last digits of frequencies are those of a C library; those of a float are the same everywhere.
        part.factor = double{static_cast<float>(frequency * frequency / (rest_frequency * rest_frequency))};
        part.slow =
            slow_fields(part, stiffness, 3 * static_cast<Eigen::Index>(points.size()), slow_part * rest_frequency);
    }
    std::erase_if(scaling.parts, [](const ScaledRegion &part) { return !(part.factor > 1.0); });
    return scaling;
}

void scale_deformation(const ScaledRegion &part, const Eigen::Matrix3Xd &x, double factor, Eigen::Matrix3Xd &field) {
    scale_in(frame_of(part.mass, x), part, x, factor, field);
}

void scale_deformation(const MassScaling &scaling, double power, const Eigen::VectorXd &x, Eigen::VectorXd &field) {
    for (const auto &part : scaling.parts) {
        auto part_values = gathered(part, field);
        scale_deformation(part, gathered(part, x), std::pow(part.factor, power), part_values);
        scatter(part, part_values, field);
    }
}

void scale_acceleration(const ScaledRegion &part, const Eigen::Matrix3Xd &x, const Eigen::Matrix3Xd &v,
                        Eigen::Matrix3Xd &acceleration) {
    const auto frame = frame_of(part.mass, x);
    const auto turned = turning(frame, part, x, v);
    acceleration -= turned;
    scale_in(frame, part, x, 1.0 / part.factor, acceleration);
    acceleration += turned;
}

void scale_acceleration(const MassScaling &scaling, const Eigen::VectorXd &x, const Eigen::VectorXd &v,
                        Eigen::VectorXd &acceleration) {
    for (const auto &part : scaling.parts) {
        auto part_values = gathered(part, acceleration);
        scale_acceleration(part, gathered(part, x), gathered(part, v), part_values);
        scatter(part, part_values, acceleration);
    }
}

} // namespace livermark::msm
