#include "load_cases/experiments/experiment.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <numbers>
#include <numeric>
#include <optional>

#include "core/mesh/tetra_mesh.hpp"
#include "core/support/input_error.hpp"
#include "core/units.hpp"
#include "load_cases/experiments/markers.hpp"

namespace livermark::experiments {

namespace {

using core::Vector3;

Vector3 mean(std::span<const Vector3> vectors) {
    Vector3 sum = Vector3::Zero();
    for (const auto &vector : vectors)
        sum += vector;
    return sum / static_cast<double>(vectors.size());
}

int num_coefficients(int degree) {
    return (degree + 1) * (degree + 2) / 2;
}

} // namespace

FittedMotion::FittedMotion(std::span<const Vector3> positions, std::span<const Vector3> displacements, int degree,
                           const std::string &place)
    : degree_(degree), middle_(mean(positions)) {
    const int needed = num_coefficients(degree);
    const auto count = static_cast<int>(positions.size());
    const auto refuse = [&](const std::string &fault) {
        throw support::InputError("{}: {}; take a polynomial of lower degree, or more markers", place, fault);
    };
    if (count < needed)
        refuse(fmt::format("{} markers do not determine the {} coefficients of a polynomial of degree {}", count,
                           needed, degree));
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (const auto &position : positions)
        spread += (position - middle_) * (position - middle_).transpose() / count;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread); // ascending
    for (int axis = 0; axis < 2; ++axis) {
        const double length = std::sqrt(std::max(axes.eigenvalues()[2 - axis], 0.0));
        axes_.row(axis) = axes.eigenvectors().col(2 - axis).transpose() / (length > 0.0 ? length : 1.0);
    }
    Eigen::MatrixXd basis(count, needed);
    Eigen::MatrixX3d moved(count, 3);
    for (int k = 0; k < count; ++k) {
        basis.row(k) = monomials(positions[k]);
        moved.row(k) = displacements[k].transpose();
    }
    Eigen::ColPivHouseholderQR<Eigen::MatrixXd> factor(basis);
    factor.setThreshold(1e-8);
    if (factor.rank() < needed)
        refuse(
            fmt::format("its {} markers lie so that they do not determine a polynomial of degree {}", count, degree));
    coefficients_ = factor.solve(moved);
    residual_ = std::sqrt((basis * coefficients_ - moved).squaredNorm() / count);
}

Eigen::RowVectorXd FittedMotion::monomials(const Vector3 &point) const {
    const Eigen::Vector2d along = axes_ * (point - middle_);
    Eigen::RowVectorXd values(num_coefficients(degree_));
    int next = 0;
    for (int a = 0; a <= degree_; ++a)
        for (int b = 0; a + b <= degree_; ++b)
            values[next++] = std::pow(along[0], a) * std::pow(along[1], b);
    return values;
}

Vector3 FittedMotion::at(const Vector3 &point) const {
    return (monomials(point) * coefficients_).transpose();
}

void drive(core::LoadCase &load_case, const core::TetraMesh &mesh, const PlaceMotion &place) {
    const auto facets = core::facets_in_patch(mesh, place.patch);
    if (facets.empty())
        throw support::InputError("markers drive '{}', and the body has no such patch; it has {}",
                                  support::shown(place.patch), fmt::join(core::patches_of(mesh), ", "));
    load_case.node_shift.resize(mesh.points.size(), Vector3::Zero());
    for (const int f : facets) {
        if (!load_case.is_constrained(f))
            throw support::InputError("markers drive '{}', and nothing constrains it; give it a [[condition]] with "
                                      "displacement = [0.0, 0.0, 0.0]",
                                      place.patch);
        for (const int node : mesh.boundary_triangles[f])
            load_case.node_shift[node] = place.motion.at(mesh.points[node]);
    }
}

Vector3 straight_line(const PlaceMotion &from, const PlaceMotion &to, const Vector3 &point) {
    const Vector3 way = to.motion.middle() - from.motion.middle();
    const double part = (point - from.motion.middle()).dot(way) / way.squaredNorm();
    return (1.0 - part) * from.motion.at(point) + part * to.motion.at(point);
}

AffineMotion best_rigid_motion(std::span<const Vector3> points, std::span<const Vector3> targets) {
    AffineMotion motion{.from = mean(points), .to = mean(targets)};
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    for (std::size_t k = 0; k < points.size(); ++k)
        covariance += (targets[k] - motion.to) * (points[k] - motion.from).transpose();
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Vector3 signs = Vector3::Ones();
    signs[2] = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0; // no reflection
    motion.gradient = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
    return motion;
}

std::optional<AffineMotion> best_affine_motion(std::span<const Vector3> points, std::span<const Vector3> targets) {
    constexpr double thinnest = 1e-6; // of the extent, below which points lie in a plane
    const auto count = static_cast<Eigen::Index>(points.size());
    if (count < 4)
        return std::nullopt;
    AffineMotion motion{.from = mean(points), .to = mean(targets)};
    Eigen::MatrixXd from(count, 3), to(count, 3);
    for (Eigen::Index k = 0; k < count; ++k) {
        from.row(k) = (points[k] - motion.from).transpose();
        to.row(k) = (targets[k] - motion.to).transpose();
    }
    const Eigen::JacobiSVD<Eigen::MatrixXd> parts(from, Eigen::ComputeThinU | Eigen::ComputeThinV);
    if (!(parts.singularValues()[2] > thinnest * parts.singularValues()[0]))
        return std::nullopt;
    motion.gradient = parts.solve(to).transpose();
    return motion;
}

MarkerMotion mean_motion(std::span<const MarkerMotion> repeats) {
    auto mean = repeats.front();
    for (auto &displacement : mean.displacement)
        displacement.setZero();
    for (const auto &repeat : repeats)
        for (std::size_t i = 0; i < mean.displacement.size(); ++i)
            mean.displacement[i] += repeat.displacement[i] / static_cast<double>(repeats.size());
    return mean;
}

core::Body with_added_mass(core::Body body, double mass, const Vector3 &low, const Vector3 &high) {
    auto &mesh = body.mesh;
    const auto volumes = core::tetrahedron_volumes(mesh);
    const auto added = static_cast<int>(mesh.region_names.size());
    double volume = 0.0;
    int region = -1;
    for (int t = 0; t < mesh.num_tetrahedra(); ++t) {
        Vector3 middle = Vector3::Zero();
        for (const int node : mesh.tetrahedra[t])
            middle += 0.25 * mesh.points[node];
        if ((middle.array() < low.array()).any() || (middle.array() > high.array()).any())
            continue;
        if (region >= 0 && region != mesh.region[t])
            throw support::InputError("a mass of {} kg is put into regions {} and {} of {}; put it into one", mass,
                                      mesh.region_names[region], mesh.region_names[mesh.region[t]], body.name);
        region = mesh.region[t];
        mesh.region[t] = added;
        volume += volumes[t];
    }
    if (region < 0)
        throw support::InputError(
            "a mass of {} kg is put where {} has no tetrahedra; take a larger box, or shorter edges", mass, body.name);
    mesh.region_names.push_back(mesh.region_names[region] + " with a mass");
    body.materials.push_back(body.materials[region]);
    body.materials.back().density += mass / volume;
    return body;
}

namespace {

/// Parts of the extent and of the thickness of a body: how far a marker may stand off it.
constexpr double largest_peg = 0.2, largest_peg_of_thickness = 0.5;
/// Part of the thickness from which on a peg is named.
constexpr double named_peg = 0.1;
constexpr std::size_t most_named = 5;
/// Part of the extent within which two markers are in one place.
constexpr double same_place = 1e-6;

/// Thickness of a body [m]: the smaller of the thinnest side of the box around it and of its mean chord 4 V / S
/// (Cauchy 1850), which knows a rod that is bent or lies askew in the box.
double thickness_of(const core::TetraMesh &mesh) {
    const auto volumes = core::tetrahedron_volumes(mesh);
    double surface = 0.0;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        surface += core::area_vector(mesh, f).norm();
    return std::min(core::bounding_box(mesh.points).sizes().minCoeff(),
                    4.0 * std::accumulate(volumes.begin(), volumes.end(), 0.0) / surface);
}

void refuse_markers_in_one_place(std::span<const Marker> markers, double extent, const std::string &place) {
    const double least = same_place * extent;
    const auto x = [&](std::size_t k) { return markers[k].position.x(); };
    std::vector<std::size_t> along_x(markers.size());
    std::iota(along_x.begin(), along_x.end(), std::size_t{0});
    std::ranges::stable_sort(along_x, {}, x);
    for (auto a = along_x.begin(); a != along_x.end(); ++a)
        for (auto b = a + 1; b != along_x.end() && x(*b) - x(*a) <= least; ++b)
            if ((markers[*a].position - markers[*b].position).norm() <= least) {
                const auto [first, second] = std::minmax(*a, *b);
                throw support::InputError("{}: markers {} and {} are in the same place at rest; correct one, or leave "
                                          "it out",
                                          place, markers[first].name, markers[second].name);
            }
}

} // namespace

std::vector<std::string> doubts_about_markers(std::span<const Marker> markers, const core::TetraMesh &mesh,
                                              std::span<const double> outside) {
    const double thickness = thickness_of(mesh);
    std::vector<std::string> named;
    for (std::size_t k = 0; k < markers.size(); ++k)
        if (outside[k] > named_peg * thickness)
            named.push_back(fmt::format("{} ({:.3g} mm)", markers[k].name, core::millimetres * outside[k]));
    if (named.empty())
        return {};
    const std::size_t num_others = named.size() - std::min(named.size(), most_named);
    named.resize(named.size() - num_others);
    return {fmt::format("markers {}{} are outside the body by more than a tenth of its thickness of {:.3g} mm, and are "
                        "extrapolated from the nearest point of its surface",
                        fmt::join(named, ", "), num_others > 0 ? fmt::format(" and {} others", num_others) : "",
                        core::millimetres * thickness)};
}

void check(const Experiment &experiment, const std::string &place) {
    const auto body = experiment.body(experiment.edge_length);
    const double extent = core::extent(body.mesh.points);
    const double farthest = std::min(largest_peg * extent, largest_peg_of_thickness * thickness_of(body.mesh));
    std::vector<Vector3> positions;
    for (const auto &marker : experiment.markers)
        positions.push_back(marker.position);
    const auto outside = MarkerField(body.mesh, positions).outside();
    for (std::size_t k = 0; k < outside.size(); ++k)
        if (!(outside[k] <= farthest))
            throw support::InputError("{}: marker {} is {:.3g} mm outside the body, and {:.3g} mm are the most for one "
                                      "on a peg (half of the thickness, a fifth of the diagonal); check the unit "
                                      "and the frame of the markers, and where the body is",
                                      place, experiment.markers[k].name, core::millimetres * outside[k],
                                      core::millimetres * farthest);
    refuse_markers_in_one_place(experiment.markers, extent, place);
    if (experiment.states.empty())
        throw support::InputError("{}: nothing was measured; add a state", place);
    for (const auto &ring_down : experiment.ring_downs)
        for (const auto &repeat : ring_down.repeats)
            for (const auto &displacement : repeat.displacement)
                if (!(displacement.norm() <= extent))
                    throw support::InputError(
                        "{}: a marker is {:.3g} m from rest while {} rings down, and the body is {:.3g} m across; "
                        "check the unit and whether positions stand where displacements should",
                        place, displacement.norm(), ring_down.state, extent);
    for (const auto &state : experiment.states) {
        bool is_compared = false;
        if (state.displacement.size() != experiment.markers.size())
            throw support::InputError("{}: state {} has {} markers and the body {}; give each a position", place,
                                      state.name, state.displacement.size(), experiment.markers.size());
        for (std::size_t k = 0; k < state.displacement.size(); ++k) {
            const auto &displacement = state.displacement[k];
            const bool is_seen = displacement.allFinite();
            if (is_seen && displacement.norm() > extent)
                throw support::InputError(
                    "{}: marker {} moved by {:.3g} m in state {}, and the body is {:.3g} m across; check the unit and "
                    "whether positions stand where displacements should",
                    place, experiment.markers[k].name, displacement.norm(), state.name, extent);
            if (experiment.markers[k].drives.empty() && is_seen)
                is_compared = true;
        }
        if (state.force)
            check_force(*state.force, state.load_case(body.mesh), place);
        if (!is_compared && !state.force)
            throw support::InputError("{}: no marker can be compared in state {}; give one that drives no place and "
                                      "has a position there",
                                      place, state.name);
    }
}

std::vector<PlaceMotion> driven_places(const Experiment &experiment, const MeasuredState &state) {
    std::vector<std::string> patches;
    for (const auto &marker : experiment.markers)
        if (!marker.drives.empty() && std::ranges::find(patches, marker.drives) == patches.end())
            patches.push_back(marker.drives);
    std::vector<PlaceMotion> places;
    for (const auto &patch : patches) {
        std::vector<Vector3> positions, displacements;
        for (std::size_t k = 0; k < experiment.markers.size(); ++k)
            if (experiment.markers[k].drives == patch) {
                positions.push_back(experiment.markers[k].position);
                displacements.push_back(state.displacement[k]);
            }
        places.push_back({patch, FittedMotion(positions, displacements, experiment.fit_degree,
                                              fmt::format("{}: place {}", experiment.name, patch))});
    }
    return places;
}

core::Problem problem_of(const Experiment &experiment, const MeasuredState &state,
                         const std::shared_ptr<const core::Body> &body) {
    core::Problem problem{body, state.load_case(body->mesh)};
    for (const auto &place : driven_places(experiment, state))
        drive(problem.load_case, body->mesh, place);
    if (state.force) {
        problem.load_case.path.clear();
        for (const double way : state.force->way)
            problem.load_case.path.push_back(way / state.force->way.back());
    }
    return problem;
}

namespace {

constexpr int fewest_records = 8;
constexpr double tau = 2.0 * std::numbers::pi;

/// Remainder of some columns when the best oscillation of a frequency and a damping ratio is taken off.
double left_over(const Eigen::MatrixXd &columns, double interval, double frequency, double ratio) {
    const auto count = columns.rows();
    Eigen::MatrixXd basis(count, 4);
    for (Eigen::Index j = 0; j < count; ++j) {
        const double phase = tau * frequency * interval * static_cast<double>(j), decay = std::exp(-ratio * phase);
        basis.row(j) << 1.0, static_cast<double>(j) / static_cast<double>(count), decay * std::cos(phase),
            decay * std::sin(phase);
    }
    const Eigen::HouseholderQR<Eigen::MatrixXd> factor(basis);
    const Eigen::MatrixXd rotated = factor.householderQ().transpose() * columns;
    return rotated.bottomRows(count - 4).squaredNorm();
}

double range_of(const std::vector<double> &values) {
    const auto [least, most] = std::ranges::minmax_element(values);
    return *most - *least;
}

/// The mean displacement of some markers in a record.
Vector3 mean_displacement(const MarkerMotion &motion, std::span<const int> markers, int record) {
    Vector3 sum = Vector3::Zero();
    for (const int marker : markers)
        sum += motion.at(record, marker);
    return sum / static_cast<double>(markers.size());
}

} // namespace

Ringing fit_ringing(const MarkerMotion &motion, std::span<const int> markers, const Window &window) {
    const int count = window.end - window.first;
    if (count < fewest_records)
        return {};
    Eigen::MatrixXd columns(count, 3 * static_cast<Eigen::Index>(markers.size()));
    for (int j = 0; j < count; ++j)
        for (std::size_t k = 0; k < markers.size(); ++k)
            columns.block<1, 3>(j, 3 * static_cast<Eigen::Index>(k)) =
                motion.at(window.first + j, markers[k]).transpose();
    if (!columns.allFinite())
        return {};
    const double duration = count * motion.interval;
    Ringing best{1.5 / duration, 0.05};
    double least = left_over(columns, motion.interval, best.frequency, best.ratio);
    const auto take_if_better = [&](double frequency, double ratio) {
        const double left = left_over(columns, motion.interval, frequency, ratio);
        if (!(left < least))
            return false;
        best = {frequency, ratio};
        least = left;
        return true;
    };
    // Slower motion than one and a half periods is not told from creep, faster than four records a period not from
    // noise.
    for (double frequency = 1.5 / duration; frequency < 0.25 / motion.interval; frequency += 0.25 / duration)
        for (const double ratio : {0.02, 0.1, 0.3})
            take_if_better(frequency, ratio);
    double step = 0.1;
    while (step > 1e-6) { // compass search
        const double frequency = best.frequency, ratio = best.ratio;
        const bool is_better = take_if_better(frequency * (1.0 + 0.3 * step), ratio) ||
                               take_if_better(frequency * (1.0 - 0.3 * step), ratio) ||
                               take_if_better(frequency, ratio + step) || take_if_better(frequency, ratio - step);
        if (!is_better)
            step *= 0.5;
    }
    return best;
}

Ringing fit_ringing(const MarkerMotion &motion, std::span<const int> markers) {
    return fit_ringing(motion, markers, {0, motion.num_records()});
}

MeasuredRinging measured_ringing(std::span<const MarkerMotion> repeats, std::span<const int> markers) {
    MeasuredRinging measured{.value = {0.0, 0.0}};
    std::vector<double> frequencies, ratios;
    for (const auto &repeat : repeats) {
        const auto whole = fit_ringing(repeat, markers);
        measured.value.frequency += whole.frequency / static_cast<double>(repeats.size());
        measured.value.ratio += whole.ratio / static_cast<double>(repeats.size());
        const int count = repeat.num_records();
        const int period = std::isfinite(whole.frequency)
                               ? static_cast<int>(std::lround(1.0 / (whole.frequency * repeat.interval)))
                               : 0;
        for (const Window window :
             {Window{0, count}, Window{std::min(period, count / 2), count}, Window{0, count / 2}}) {
            const auto add = [&](std::span<const int> some) {
                const auto fitted = fit_ringing(repeat, some, window);
                frequencies.push_back(fitted.frequency);
                ratios.push_back(fitted.ratio);
            };
            add(markers);
            for (std::size_t k = 0; k < markers.size(); ++k)
                add(markers.subspan(k, 1));
        }
    }
    measured.frequency_uncertainty = 0.5 * range_of(frequencies);
    measured.ratio_uncertainty = 0.5 * range_of(ratios);
    return measured;
}

std::vector<double> swings(const MarkerMotion &motion, std::span<const int> markers, double frequency, int count) {
    std::vector<double> found(count, std::numeric_limits<double>::quiet_NaN());
    const double half_period = 0.5 / (frequency * motion.interval);
    const int opposite = static_cast<int>(std::lround(half_period));
    if (!std::isfinite(half_period) || opposite < 1 || opposite >= motion.num_records())
        return found;
    const Vector3 start = mean_displacement(motion, markers, 0);
    const Vector3 way = (mean_displacement(motion, markers, opposite) - start).normalized();
    double before = 0.0, direction = 1.0;
    for (int n = 1; n <= count; ++n) {
        const int first = static_cast<int>(std::ceil((n - 0.5) * half_period)),
                  last = static_cast<int>((n + 0.5) * half_period);
        if (last + 1 >= motion.num_records() || first < 1)
            break;
        const auto along = [&](int record) {
            return direction * (mean_displacement(motion, markers, record) - start).dot(way);
        };
        int turn = first;
        for (int record = first; record <= last; ++record)
            if (along(record) > along(turn))
                turn = record;
        const double a = along(turn - 1), b = along(turn), c = along(turn + 1), curvature = a - 2.0 * b + c;
        // The vertex of the parabola through three records.
        const double at_turn = direction * (curvature < 0.0 ? b - (a - c) * (a - c) / (8.0 * curvature) : b);
        found[n - 1] = 0.5 * std::abs(at_turn - before);
        before = at_turn;
        direction = -direction;
    }
    return found;
}

} // namespace livermark::experiments
