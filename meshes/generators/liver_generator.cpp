#include "meshes/generators/liver_generator.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <stdexcept>

#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "meshes/anatomy/liver_patches.hpp"
#include "meshes/generators/box_generator.hpp"
#include "meshes/generators/liver_shape.hpp"
#include "meshes/io/mesh_checks.hpp"
#include "meshes/io/mesh_files.hpp"

namespace livermark::meshes {

namespace {

using core::Vector3;

constexpr int smallest_target = 2000;
/// Tetrahedra of the two canonical bodies: the counts of the seed paper (10.11113/jt.v75.5068).
constexpr int healthy_liver_tetrahedra = 15806;
constexpr int tumour_liver_tetrahedra = 19478;

/// A triangulated lesion of the volume of its ellipsoid, with edges somewhat shorter than the capsule's: at least eight
/// triangles to a great circle where that does not make edges below a third of the capsule's, which would set the time
/// step.
SurfaceMesh lesion_surface(const Lesion &lesion, double edge) {
    const double radius = cube_root(1e9 * lesion.semi_axes.prod()) / 1e3;
    const double chord = 1.1 * radius; // edge of the icosahedron
    const double wanted = std::max(std::min(2.0, std::floor(chord / (edge / 3.0))), std::round(chord / (0.55 * edge)));
    SurfaceMesh surface = geodesic_sphere(std::max(1, static_cast<int>(wanted)));
    const double scale = cube_root(4.18879020478639098 / enclosed_volume(surface)); // 4 pi / 3, the unit ball
    for (auto &point : surface.points) {
        const Vector3 on_ball = scale * point;
        point = lesion.center;
        for (int d = 0; d < 3; ++d)
            point += on_ball[d] * lesion.semi_axes[d] * lesion.axes[d];
    }
    return surface;
}

std::vector<SurfaceMesh> lesion_surfaces(const std::vector<Lesion> &lesions, double edge) {
    std::vector<SurfaceMesh> surfaces;
    for (const auto &lesion : lesions)
        surfaces.push_back(lesion_surface(lesion, edge));
    return surfaces;
}

/// The liver that ships, or another one.
struct Liver {
    LiverShape shape;
    std::array<Vector3, 2> box;
    std::vector<Lesion> lesions;
    double size = 1.0; ///< relative to the one that ships
};

core::TetraMesh mesh_with_edge(const Liver &liver, double edge, const std::vector<SurfaceMesh> &lesions) {
    // The inner edges come out about 1.2 times this, so a little longer than those of the capsule, which has the
    // detail.
    const double inner_size = 0.85 * edge;
    // Fine enough for the sharp inferior margin at any edge length.
    const double spacing = std::min(0.7 * edge, 0.006 * liver.size);
    const auto &[low, high] = liver.box;
    const auto level = [&](const Vector3 &point) { return liver_level(point, liver.shape); };
    const auto project = [&](const Vector3 &point) { return project_to_liver(point, liver.shape); };
    const SurfaceMesh capsule = remesh(march_tetrahedra(level, low, high, spacing), project, edge);
    return fill_with_tetrahedra(capsule, lesions, inner_size);
}

/// The number of tetrahedra jumps by some 0.5 % between neighbouring edge lengths, so the search takes the best of a
/// few attempts that a fixed-point iteration scatters around the target.
/// @param is_good  whether a mesh may be taken
core::TetraMesh search_for_count(const Liver &liver, int target,
                                 const std::function<bool(const core::TetraMesh &)> &is_good) {
    constexpr int max_attempts = 16;
    constexpr double good_enough = 0.003;
    constexpr double healthy_edge = 0.0087; // [m], gives about healthy_liver_tetrahedra
    double edge = liver.size * healthy_edge * cube_root(static_cast<double>(healthy_liver_tetrahedra) / target);
    // The lesions stay as they are during the search: their subdivision changes in steps that it could not step over.
    const auto lesions = lesion_surfaces(liver.lesions, edge);
    core::TetraMesh best;
    bool is_best_good = false;
    for (int attempt = 0; attempt < max_attempts; ++attempt) {
        core::TetraMesh mesh = mesh_with_edge(liver, edge, lesions);
        if (mesh.tetrahedra.empty())
            throw std::runtime_error("gmsh returned a liver without tetrahedra");
        const int miss = std::abs(mesh.num_tetrahedra() - target);
        edge *= cube_root(static_cast<double>(mesh.num_tetrahedra()) / target);
        const bool good = is_good(mesh);
        if (best.tetrahedra.empty() || (good && !is_best_good) ||
            (good == is_best_good && miss < std::abs(best.num_tetrahedra() - target))) {
            best = std::move(mesh);
            is_best_good = good;
        }
        if (good && miss <= good_enough * target)
            break;
        if (!good && miss <= good_enough * target)
            edge *= 1.004; // another surface, which may be better
    }
    return best;
}

double shortest_edge_allowed(const MeshFigures &figures, bool has_lesions) {
    return (has_lesions ? 0.25 : 0.35) * figures.mean_edge;
}

constexpr double smallest_quality_allowed = 0.2;

bool has_quality(const core::TetraMesh &mesh, bool has_lesions) {
    const auto figures = mesh_figures(mesh);
    return figures.smallest_quality >= smallest_quality_allowed &&
           figures.shortest_edge >= shortest_edge_allowed(figures, has_lesions);
}

void require_canonical_figures(const core::TetraMesh &mesh, int target, bool tumours) {
    const auto figures = mesh_figures(mesh);
    const double shortest = shortest_edge_allowed(figures, tumours);
    if (std::abs(figures.num_tetrahedra - target) > 0.005 * target ||
        figures.smallest_quality < smallest_quality_allowed || figures.shortest_edge < shortest ||
        std::abs(figures.volume - 1.5e-3) > 0.03 * 1.5e-3)
        throw std::runtime_error(fmt::format(
            "the generated liver misses what a canonical body must have: {} tetrahedra within 0.5 %, smallest "
            "quality 0.2, shortest edge {:.2f} mm, 1500 mL within 3 %; it has\n{}",
            target, 1e3 * shortest, to_text(figures)));
}

int checked_target(int asked_for, bool has_lesions) {
    const int canonical = has_lesions ? tumour_liver_tetrahedra : healthy_liver_tetrahedra;
    const int target = asked_for == 0 ? canonical : asked_for;
    if (target < smallest_target)
        throw support::InputError("a liver of {} tetrahedra cannot show its anatomy; ask for {} or more", target,
                                  smallest_target);
    if (target > most_tetrahedra)
        throw support::InputError("a liver of {} tetrahedra is too large; ask for {:g} or fewer", target,
                                  most_tetrahedra);
    return target;
}

void round_points(core::TetraMesh &mesh) {
    for (auto &point : mesh.points)
        for (auto &coordinate : point)
            coordinate = std::round(1e9 * coordinate) / 1e9; // whole nanometres are short in a file
}

void name_regions(core::TetraMesh &mesh, std::size_t num_lesions) {
    mesh.region_names = {"parenchyma"};
    for (std::size_t i = 1; i <= num_lesions; ++i)
        mesh.region_names.push_back(fmt::format("tumour_{}", i));
}

} // namespace

core::TetraMesh generate_liver(const LiverOptions &options) {
    const int target = checked_target(options.target_tetrahedra, options.tumours);
    const Liver liver{{}, liver_bounding_box(), options.tumours ? liver_lesions() : std::vector<Lesion>()};
    core::TetraMesh mesh = search_for_count(liver, target, [](const core::TetraMesh &) { return true; });
    round_points(mesh);
    name_regions(mesh, liver.lesions.size());
    assign_liver_patches(mesh);
    if (target == (options.tumours ? tumour_liver_tetrahedra : healthy_liver_tetrahedra))
        require_canonical_figures(mesh, target, options.tumours);
    return mesh;
}

core::TetraMesh generate_liver(const LiverVariant &variant, int target_tetrahedra) {
    const bool has_lesions = !variant.lesions.empty();
    const int target = checked_target(target_tetrahedra, has_lesions);
    const Liver liver{variant.shape, liver_bounding_box(variant.shape), variant.lesions,
                      cube_root(variant.volume / 1.5e-3)};
    core::TetraMesh mesh =
        search_for_count(liver, target, [&](const core::TetraMesh &tried) { return has_quality(tried, has_lesions); });
    name_regions(mesh, variant.lesions.size());
    assign_liver_patches(mesh, variant.shape);
    // Flat facets cut off a little of a convex body.
    const double scale = cube_root(variant.volume / mesh_figures(mesh).volume);
    for (auto &point : mesh.points)
        point *= scale;
    round_points(mesh);
    if (target >= healthy_liver_tetrahedra && !has_quality(mesh, has_lesions))
        throw std::runtime_error(fmt::format("the generated variant {} of the liver misses the quality of a liver that "
                                             "ships; ask for another number of tetrahedra; it has\n{}",
                                             variant.number, to_text(mesh_figures(mesh))));
    return mesh;
}

namespace {

using Eigen::Matrix3d;

constexpr double far = 0.04, right_angle = 0.015; // [m]
constexpr double weight_of_prior = 1e-3;          // [m]
constexpr double usual_strain = 0.15;

constexpr int num_affine = 12, num_lengths = 6, num_unknown = num_affine + num_lengths;
constexpr int tongue_index = num_lengths - 1;
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
        shape.tongue_length = 40.0 * std::exp(0.35 * t[tongue_index]);
    return shape;
}

/// Logarithmic strain of a map along the axes it leads to, without its change of volume.
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
        const Matrix3d normal_map = state.fit.linear.inverse().transpose();
        const double part = 1.0 / static_cast<double>(samples_.size());
        for (const auto &sample : samples_) {
            const Vector3 place = state.fit.place(sample.place);
            const double level = liver_level(place, state.fit.shape);
            const Vector3 gradient = liver_gradient(place, state.fit.shape);
            const double cosine = (normal_map * sample.area).normalized().dot(gradient.normalized());
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
        const double length_weight = std::pow(weight_of_prior, 2),
                     strain_weight = length_weight / std::pow(usual_strain, 2);
        const Matrix3d strain = strain_of(state.fit.linear);
        // Among the entries of a small further map E, the strain changes by the symmetric part without the trace.
        for (int row = 0; row < 3; ++row)
            for (int column = 0; column < 3; ++column) {
                Matrix3d change = Matrix3d::Zero();
                change(row, column) += 0.5;
                change(column, row) += 0.5;
                if (row == column)
                    change -= Matrix3d::Identity() / 3.0;
                slope[3 * row + column] += strain_weight * change.cwiseProduct(strain).sum();
                for (int k = 0; k < 9; ++k)
                    matrix(3 * row + column, k) += strain_weight * change(k / 3, k % 3);
            }
        matrix.diagonal().tail<num_lengths>().array() += length_weight;
        slope.tail<num_lengths>() += length_weight * state.lengths;
    }

    const std::vector<BoundarySample> &samples_;
    bool has_tongue_;
};

} // namespace

double boundary_misfit(const LiverFit &fit, const std::vector<BoundarySample> &samples) {
    const Matrix3d normal_map = fit.linear.inverse().transpose();
    double sum = 0.0;
    for (const auto &sample : samples) {
        const Vector3 place = fit.place(sample.place);
        const double off =
            1.0 - (normal_map * sample.area).normalized().dot(liver_gradient(place, fit.shape).normalized());
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

void write_liver_body(const std::filesystem::path &mesh_file, const core::TetraMesh &mesh, const LiverVariant &variant,
                      const std::string &command) {
    check_name_of_mesh(mesh_file);
    auto text = fmt::format("# Axes: x to the patient's left, y posterior, z superior (LPS) [m].\n"
                            "title = \"Liver of {:.2f} L, {} lesions\"\nmesh = '{}'\ngenerator = '{}'\n",
                            1e3 * variant.volume, variant.lesions.size(), mesh_file.filename().string(), command);
    for (const auto &name : mesh.region_names)
        text += fmt::format("\n[regions.{}]\ndensity = 1060.0        # kg/m^3\nyoung_modulus = {} # Pa\n"
                            "poisson_ratio = 0.45\nsource = \"as of the livers that ship\"\n",
                            name, name == "parenchyma" ? "5000.0" : "50000.0");
    write_msh(mesh_file, mesh);
    auto body_file = mesh_file;
    support::write_whole(body_file.replace_extension(".toml"), text);
}

} // namespace livermark::meshes
