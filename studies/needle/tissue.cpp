#include "studies/needle/tissue.hpp"

#include <utility>

namespace livermark::studies {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// What is learnt from a change of forces has to be as stiff as the model says, but for this factor: smaller changes
/// are what searches for equilibria leave.
constexpr double most_surprising = 10.0;

/// Two directions across an axis, and the axis itself, as rows.
Eigen::Matrix3d frame_of(const core::Vector3 &axis) {
    Eigen::Matrix3d frame;
    frame.row(0) = axis;
    frame.row(1) = axis.unitOrthogonal();
    frame.row(2) = axis.cross(frame.row(1).transpose());
    return frame;
}

/// Number of a component of a place, see Tissue.
Index number_of(Index place, int component, Index count) {
    return component == 0 ? place : count + 2 * place + component - 1;
}

MatrixXd in_frame(const MatrixXd &compliance, const Eigen::Matrix3d &frame) {
    const Index count = compliance.rows() / 3;
    MatrixXd result(3 * count, 3 * count);
    for (Index i = 0; i < count; ++i)
        for (Index j = 0; j < count; ++j) {
            // Solvers leave a rounding.
            const Eigen::Matrix3d block =
                0.5 * frame *
                (compliance.block<3, 3>(3 * i, 3 * j) + compliance.block<3, 3>(3 * j, 3 * i).transpose()) *
                frame.transpose();
            for (int a = 0; a < 3; ++a)
                for (int b = 0; b < 3; ++b)
                    result(number_of(i, a, count), number_of(j, b, count)) = block(a, b);
        }
    return result;
}

} // namespace

Tissue::Tissue(core::PushedBody &body, const core::Vector3 &axis)
    : body_(body), frame_(frame_of(axis)), size_(body.compliance().rows() / 3),
      compliance_(in_frame(body.compliance(), frame_)), offset_(VectorXd::Zero(3 * size_)), pushed_force_(offset_),
      pushed_displacement_(offset_) {}

const Tissue::Held &Tissue::held(Index count) {
    const auto found = held_.find(count);
    if (found != held_.end())
        return found->second;
    Held held;
    MatrixXd across = compliance_.block(size_, size_, 2 * count, 2 * count);
    across.diagonal().array() += place_softness;
    held.across.compute(across);
    const MatrixXd between = compliance_.block(0, size_, size_, 2 * count);
    held.of_hold = held.across.solve(between.transpose()).transpose();
    held.along = compliance_.topLeftCorner(size_, size_) - held.of_hold * between.transpose();
    return held_.emplace(count, std::move(held)).first->second;
}

VectorXd Tissue::along_without_forces(const VectorXd &hold) {
    return offset_.head(size_) + held(hold.size() / 2).of_hold * (hold - offset_.segment(size_, hold.size()));
}

VectorXd Tissue::forces_across(const VectorXd &along, const VectorXd &hold) {
    return held(hold.size() / 2)
        .across.solve(hold - offset_.segment(size_, hold.size()) -
                      compliance_.block(0, size_, size_, hold.size()).transpose() * along);
}

VectorXd Tissue::displacement_across(const VectorXd &along, const VectorXd &across) const {
    return offset_.tail(2 * size_) + compliance_.bottomLeftCorner(2 * size_, size_) * along +
           compliance_.block(size_, size_, 2 * size_, across.size()) * across;
}

core::Vector3 Tissue::in_space(double along, double across_1, double across_2) const {
    return frame_.transpose() * core::Vector3(along, across_1, across_2);
}

VectorXd Tissue::joined(const VectorXd &along, const VectorXd &across) const {
    VectorXd all = VectorXd::Zero(3 * size_);
    all.head(size_) = along;
    all.segment(size_, across.size()) = across;
    return all;
}

std::optional<double> Tissue::push(const VectorXd &along, const VectorXd &across, double tolerance) {
    const VectorXd force = joined(along, across);
    VectorXd in_space(3 * size_), displacement(3 * size_);
    for (Index k = 0; k < size_; ++k)
        in_space.segment<3>(3 * k) =
            this->in_space(force[k], force[number_of(k, 1, size_)], force[number_of(k, 2, size_)]);
    const auto found = body_.push(in_space);
    if (!found)
        return std::nullopt;
    for (Index k = 0; k < size_; ++k) {
        const core::Vector3 of_place = frame_ * found->displacement.segment<3>(3 * k);
        for (int a = 0; a < 3; ++a)
            displacement[number_of(k, a, size_)] = of_place[a];
    }
    const double farthest = (displacement - offset_ - compliance_ * force).cwiseAbs().maxCoeff();
    if (farthest > tolerance)
        learn(force, displacement);
    pushed_force_ = force;
    pushed_displacement_ = displacement;
    pushed_stored_ = found->stored;
    return farthest;
}

double Tissue::stored(const VectorXd &along, const VectorXd &across) const {
    const VectorXd force = joined(along, across);
    return pushed_stored_ + 0.5 * (force + pushed_force_).dot(compliance_ * (force - pushed_force_));
}

void Tissue::learn(const VectorXd &force, const VectorXd &displacement) {
    const VectorXd step = displacement - pushed_displacement_, change = force - pushed_force_;
    const VectorXd expected = compliance_ * change;
    const double work = step.dot(change), expected_work = expected.dot(change);
    if (expected_work > 0.0 && work > expected_work / most_surprising && work < expected_work * most_surprising) {
        // (1 - s y^T / w) C (1 - y s^T / w) + s s^T / w, with w = y^T s
        compliance_ += (1.0 + expected_work / work) / work * (step * step.transpose()) -
                       (expected * step.transpose() + step * expected.transpose()) / work;
        held_.clear();
    }
    offset_ = displacement - compliance_ * force;
}

} // namespace livermark::studies
