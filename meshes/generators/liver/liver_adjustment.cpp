#include "meshes/generators/liver/liver_adjustment.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace livermark::meshes {

namespace {

using core::Vector3;
using Eigen::Matrix3d;

constexpr double far = 0.04, right_angle = 0.015; // [m]
constexpr double weight_of_prior = 1e-3;          // [m]
constexpr double usual_strain = 0.15;

constexpr int num_affine = 12, num_lengths = 6, num_unknown = num_affine + num_lengths;
constexpr int tongue = num_lengths - 1;
using Lengths = Eigen::Matrix<double, num_lengths, 1>;
using Unknown = Eigen::Matrix<double, num_unknown, 1>;
using Square = Eigen::Matrix<double, num_unknown, num_unknown>;

/// @param t  of each length, in units of how far it varies among the livers of draw_liver()
LiverShape shape_at(const Lengths &t, bool has_tongue) {
    LiverShape shape;
    const double thickness = std::exp(0.1 * t[1]);
    shape.left_lobe = shape.left_lobe.cwiseProduct(Vector3(std::exp(0.15 * t[0]), thickness, thickness));
    shape.right_lobe.z() *= std::exp(0.06 * t[2]);
    shape.visceral_height += 3.5 * t[3];
    shape.stomach *= std::exp(0.06 * t[4]);
    if (has_tongue)
        shape.tongue_length = 40.0 * std::exp(0.35 * t[tongue]);
    return shape;
}

/// Of a map, along the axes it leads to, without its change of volume.
Matrix3d strain_of(const Matrix3d &linear) {
    const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(linear * linear.transpose());
    Vector3 logarithms = 0.5 * solver.eigenvalues().array().log().matrix();
    logarithms.array() -= logarithms.mean();
    return solver.eigenvectors() * logarithms.asDiagonal() * solver.eigenvectors().transpose();
}

struct State {
    LiverFit fit;
    Lengths lengths = Lengths::Zero();
    double energy = 0.0; ///< [m^2]
};

class Adjustment {
  public:
    Adjustment(const std::vector<BoundarySample> &samples, bool has_tongue)
        : samples_(samples), has_tongue_(has_tongue) {}

    State state_of(const LiverFit &fit, const Lengths &lengths) const {
        State state{fit, lengths};
        state.fit.shape = shape_at(lengths, has_tongue_);
        const double prior = lengths.squaredNorm() + strain_of(fit.linear).squaredNorm() / std::pow(usual_strain, 2);
        state.energy = boundary_misfit(state.fit, samples_) + std::pow(weight_of_prior, 2) * prior;
        return state;
    }

    State moved(const State &state, const Unknown &step) const {
        Matrix3d change = Matrix3d::Identity();
        for (int row = 0; row < 3; ++row)
            for (int column = 0; column < 3; ++column)
                change(row, column) += step[3 * row + column];
        LiverFit fit = state.fit;
        fit.linear = change * state.fit.linear;
        fit.offset = change * state.fit.offset + step.segment<3>(9);
        return state_of(fit, state.lengths + step.tail<num_lengths>());
    }

    /// Normal equations of the energy without the normals; a sample whose normal is off counts less.
    void linearise(const State &state, Square &matrix, Unknown &slope) const {
        constexpr double difference = 0.05;
        matrix.setZero();
        slope.setZero();
        std::array<LiverShape, num_lengths> changed;
        for (int k = 0; k < num_lengths; ++k)
            changed[k] = shape_at(state.lengths + difference * Lengths::Unit(k), has_tongue_);
        const Matrix3d of_normals = state.fit.linear.inverse().transpose();
        const double part = 1.0 / static_cast<double>(samples_.size());
        for (const auto &sample : samples_) {
            const Vector3 place = state.fit.place(sample.place);
            const double level = liver_level(place, state.fit.shape);
            const Vector3 gradient = liver_gradient(place, state.fit.shape);
            const double cosine = (of_normals * sample.area).normalized().dot(gradient.normalized());
            if (std::abs(level) > far || cosine <= 0.0)
                continue;
            Unknown row;
            for (int r = 0; r < 3; ++r)
                row.segment<3>(3 * r) = gradient[r] * place;
            row.segment<3>(9) = gradient;
            for (int k = 0; k < num_lengths; ++k)
                row[num_affine + k] = (liver_level(place, changed[k]) - level) / difference;
            matrix.selfadjointView<Eigen::Lower>().rankUpdate(row, part * cosine);
            slope += part * cosine * level * row;
        }
        matrix = Square(matrix.selfadjointView<Eigen::Lower>());
        add_prior(state, matrix, slope);
    }

  private:
    void add_prior(const State &state, Square &matrix, Unknown &slope) const {
        const double of_lengths = std::pow(weight_of_prior, 2), of_strain = of_lengths / std::pow(usual_strain, 2);
        const Matrix3d strain = strain_of(state.fit.linear);
        // Of the entries of a small further map E, the strain changes by the symmetric part without the trace.
        for (int row = 0; row < 3; ++row)
            for (int column = 0; column < 3; ++column) {
                Matrix3d change = Matrix3d::Zero();
                change(row, column) += 0.5;
                change(column, row) += 0.5;
                if (row == column)
                    change -= Matrix3d::Identity() / 3.0;
                slope[3 * row + column] += of_strain * change.cwiseProduct(strain).sum();
                for (int k = 0; k < 9; ++k)
                    matrix(3 * row + column, k) += of_strain * change(k / 3, k % 3);
            }
        matrix.diagonal().tail<num_lengths>().array() += of_lengths;
        slope.tail<num_lengths>() += of_lengths * state.lengths;
    }

    const std::vector<BoundarySample> &samples_;
    bool has_tongue_;
};

} // namespace

double boundary_misfit(const LiverFit &fit, const std::vector<BoundarySample> &samples) {
    const Matrix3d of_normals = fit.linear.inverse().transpose();
    double sum = 0.0;
    for (const auto &sample : samples) {
        const Vector3 place = fit.place(sample.place);
        const double off =
            1.0 - (of_normals * sample.area).normalized().dot(liver_gradient(place, fit.shape).normalized());
        sum += std::min(std::pow(liver_level(place, fit.shape), 2), far * far) + right_angle * right_angle * off;
    }
    return sum / static_cast<double>(samples.size());
}

LiverFit adjusted(const LiverFit &fit, const std::vector<BoundarySample> &samples, bool has_tongue) {
    constexpr int max_iterations = 25;
    constexpr double too_damped = 1e4, no_gain = 1e-3;
    const Adjustment adjustment(samples, has_tongue);
    State state = adjustment.state_of(fit, Lengths::Zero());
    double damping = 0.01;
    for (int iteration = 0; iteration < max_iterations && damping < too_damped; ++iteration) {
        Square matrix;
        Unknown slope;
        adjustment.linearise(state, matrix, slope);
        const double before = state.energy;
        for (; damping < too_damped; damping *= 10.0) {
            Square damped = matrix;
            damped.diagonal() *= 1.0 + damping;
            const State next = adjustment.moved(state, -damped.ldlt().solve(slope));
            if (next.energy < state.energy) {
                state = next;
                damping *= 0.1;
                break;
            }
        }
        if (before - state.energy < no_gain * before)
            break;
    }
    state.fit.distance = std::sqrt(state.energy);
    return state.fit;
}

} // namespace livermark::meshes
