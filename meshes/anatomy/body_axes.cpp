#include "meshes/anatomy/liver_patches.hpp"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <map>
#include <numbers>
#include <string_view>

#include "core/mesh/tetra_mesh.hpp"
#include "core/support/input_error.hpp"
#include "meshes/cutting/cut.hpp"
#include "meshes/io/mesh_checks.hpp"

namespace livermark::meshes {

namespace {

/// Confidence below which another orientation fits about as well (docs/studies/segmentation.md).
constexpr double doubtful = 0.06;

/// Whether a name is one that meshes get where nobody has named a part of the surface.
bool says_nothing(std::string_view name) {
    constexpr std::string_view numbered = "patch_";
    const auto number = name.substr(std::min(name.size(), numbered.size()));
    return name == "surface" || name == "unnamed" ||
           (name.starts_with(numbered) && !number.empty() &&
            number.find_first_not_of("0123456789") == std::string_view::npos);
}

std::string quoted(const std::vector<std::string> &names) {
    return fmt::format("'{}'", fmt::join(names, "', '"));
}

} // namespace

bool FoundPatches::is_doubtful() const {
    return confidence < doubtful;
}

std::optional<FoundPatches> find_anatomical_patches(core::TetraMesh &mesh,
                                                    const std::optional<Eigen::Matrix3d> &from_lps) {
    const auto fit = fit_liver(mesh, from_lps);
    auto liver = mesh;
    assign_liver_patches(liver, fit);
    const auto file_patches = mesh.patch_names;
    const auto is_there = [](const std::vector<std::string> &names, const std::string &name) {
        return std::ranges::find(names, name) != names.end();
    };
    std::map<std::string, int> number; // of what is new
    std::vector<double> area(liver.patch_names.size(), 0.0);
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f) {
        const int found = liver.boundary_patch[f];
        const auto &own = file_patches[mesh.boundary_patch[f]], &name = liver.patch_names[found];
        if (own == core::wound_patch || is_there(liver.patch_names, own) || is_there(file_patches, name))
            continue;
        const auto [entry, is_new] =
            number.emplace(says_nothing(own) ? name : fmt::format("{}{}{}", own, core::patch_joint, name),
                           std::ssize(mesh.patch_names));
        if (is_new)
            mesh.patch_names.push_back(entry->first);
        mesh.boundary_patch[f] = entry->second;
        area[found] += core::area_vector(mesh, f).norm();
    }
    keep_used_groups(mesh.boundary_patch, mesh.patch_names);
    std::vector<std::string> kept, clashes;
    for (const auto &name : file_patches)
        if (is_there(liver.patch_names, name))
            clashes.push_back(name);
        else if (!says_nothing(name))
            kept.push_back(name);
    const auto on_own = (kept.empty() ? "" : fmt::format("; {} of the mesh stand beside them", quoted(kept))) +
                        (clashes.empty() ? ""
                                         : fmt::format("; {} are as the mesh has them, because it has patches of these "
                                                       "names itself",
                                                       quoted(clashes)));
    constexpr double square_centimetres = 1e4, millimetres = 1e3;
    std::vector<std::string> places;
    for (std::size_t patch = 0; patch < area.size(); ++patch)
        if (area[patch] > 0.0)
            places.push_back(fmt::format("{} {:.0f} cm^2", liver.patch_names[patch], square_centimetres * area[patch]));
    if (places.empty())
        return std::nullopt;
    FoundPatches found{fit.confidence(), {}, fit.from_lps()};
    found.remark =
        fmt::format("patches are those of the liver that ships, deformed onto this body; it is {:.1f} mm off, "
                    "and {:.1f} mm in the next best orientation, so the confidence is {:.2f}{}: {}{}",
                    millimetres * fit.distance, millimetres * fit.next_distance, found.confidence,
                    found.is_doubtful() ? ", which is low: look at them with `livermark mesh check --picture`" : "",
                    fmt::join(places, ", "), on_own);
    return found;
}

namespace {

using core::Vector3;
using Eigen::Matrix3d;

constexpr double degrees = 180.0 / std::numbers::pi;
constexpr double another_orientation = 60.0; ///< as in fit_liver() [degrees]
/// By how much livers in LPS are found turned at most, a little more than was seen [degrees].
constexpr double seen_in_lps = 28.0, counts_as_lps = 30.0;
/// From this confidence on the shape is that of the generator, and the rotation is right to a few degrees.
constexpr double clear_confidence = 0.5, rotation_error = 3.0;

/// [degrees]
double turn_of(const Matrix3d &rotation) {
    return degrees * Eigen::AngleAxisd(rotation).angle();
}

/// Area centroids of the patches of the liver that ships, in the order of liver_patch_names() [m].
constexpr std::array<std::array<double, 3>, 7> shipped_centroids{{{-0.0074, 0.0486, 0.0219},
                                                                  {0.0062, -0.0412, -0.0167},
                                                                  {0.0119, 0.0125, -0.0352},
                                                                  {0.0633, -0.0059, 0.0445},
                                                                  {-0.0242, -0.0038, 0.0549},
                                                                  {-0.0754, 0.0091, -0.0269},
                                                                  {0.1230, -0.0113, 0.0231}}};

/// A body by the patches that its file names.
struct PatchFit {
    Matrix3d from_lps;
    double distance; ///< rms, of centroids from those of the liver that ships, at its size [m]
};

/// @return nothing if fewer than four have names of a liver's patches
std::optional<PatchFit> fit_of_patches(const core::TetraMesh &mesh) {
    constexpr Eigen::Index least_patches = 4;
    const auto names = liver_patch_names();
    Eigen::Matrix3Xd here(3, 0), shipped(3, 0);
    for (std::size_t patch = 0; patch < names.size(); ++patch) {
        const auto number = std::ranges::find(mesh.patch_names, names[patch]) - mesh.patch_names.begin();
        Vector3 sum = Vector3::Zero();
        double area = 0.0;
        for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
            if (mesh.boundary_patch[f] == number) {
                const double facet_area = core::area_vector(mesh, f).norm();
                area += facet_area;
                for (const int node : mesh.boundary_triangles[f])
                    sum += facet_area / 3.0 * mesh.points[node];
            }
        if (area > 0.0) {
            here.conservativeResize(3, here.cols() + 1);
            shipped.conservativeResize(3, here.cols());
            here.rightCols<1>() = sum / area;
            shipped.rightCols<1>() = Vector3(shipped_centroids[patch].data());
        }
    }
    if (here.cols() < least_patches)
        return std::nullopt;
    const Eigen::Matrix4d map = Eigen::umeyama(here, shipped, true);
    const Eigen::Matrix3Xd off = ((map.topLeftCorner<3, 3>() * here).colwise() + map.topRightCorner<3, 1>()) - shipped;
    const Matrix3d linear = map.topLeftCorner<3, 3>();
    return PatchFit{linear.transpose() / std::cbrt(linear.determinant()),
                    std::sqrt(off.squaredNorm() / static_cast<double>(off.cols()))};
}

core::BodyAxes axes_of_named_patches(const core::TetraMesh &mesh, std::vector<std::string> &remarks) {
    constexpr double same_shape = 2e-3; // [m]
    const auto fit = fit_of_patches(mesh);
    if (!fit)
        return {};
    const double turn = turn_of(fit->from_lps);
    if (fit->distance < same_shape && turn > rotation_error) {
        remarks.push_back(fmt::format("its patches lie as those of the liver that ships, turned by {:.0f} degrees from "
                                      "LPS; directions of load cases turn with it, 'axes' in its .toml sets others",
                                      turn));
        return {fit->from_lps, liver_patch_names(), {}};
    }
    if (turn > another_orientation)
        remarks.push_back(fmt::format("its patches lie as those of a liver that is turned by {:.0f} degrees from LPS, "
                                      "and directions of load cases are along the axes of the mesh; if it is, write "
                                      "axes = \"RAS\", or what is true, into its .toml",
                                      turn));
    return {};
}

core::BodyAxes registered(const FoundPatches &found, bool is_header_lps, std::vector<std::string> &remarks) {
    core::BodyAxes axes{Matrix3d::Identity(), liver_patch_names(), {}};
    const double turn = turn_of(found.from_lps);
    if (is_header_lps) {
        if (turn > another_orientation)
            axes.doubt = fmt::format("the header of its file says LPS, where its shape is found turned by {:.0f} "
                                     "degrees from that",
                                     turn);
        else
            remarks.push_back(fmt::format("the body is in LPS, as the header of its file says, and was found turned by "
                                          "{:.0f} degrees; directions of load cases are along its axes",
                                          turn));
    } else if (found.is_doubtful()) {
        axes.doubt = fmt::format("another orientation fits its shape about as well as that by which it is turned by "
                                 "{:.0f} degrees from LPS (confidence {:.2f})",
                                 turn, found.confidence);
    } else if (const bool is_clear = found.confidence >= clear_confidence;
               turn < (is_clear ? rotation_error : counts_as_lps)) {
        remarks.push_back(
            fmt::format("the body was found turned by {:.0f} degrees from LPS{}; directions of load cases "
                        "are along the axes of the mesh, 'axes' in a body .toml sets others",
                        turn, is_clear ? "" : fmt::format(", as livers in LPS are, by up to {:.0f}", seen_in_lps)));
    } else {
        axes.from_lps = found.from_lps;
        remarks.push_back(
            fmt::format("the body was found turned by {:.0f} degrees from LPS{}; directions of load cases "
                        "turn with it, 'axes' in a body .toml sets others",
                        turn, is_clear ? "" : fmt::format(", to within {:.0f}", seen_in_lps)));
    }
    if (!axes.doubt.empty())
        remarks.push_back(
            fmt::format("load cases with directions of the patient are left out, because {}; write axes = "
                        "\"LPS\", or what is true, into a body .toml",
                        axes.doubt));
    return axes;
}

/// Axes by three letters; a rotation unless letters repeat or make a mirror.
Matrix3d lettered(const std::string &word) {
    constexpr std::string_view ahead = "LPS", back = "RAI";
    Matrix3d from_lps = Matrix3d::Zero();
    for (std::size_t axis = 0; axis < word.size() && word.size() == 3; ++axis)
        for (std::size_t way = 0; way < ahead.size(); ++way)
            if (word[axis] == ahead[way] || word[axis] == back[way])
                from_lps(static_cast<Eigen::Index>(axis), static_cast<Eigen::Index>(way)) =
                    word[axis] == ahead[way] ? 1.0 : -1.0;
    return from_lps;
}

/// Orthonormal to the last digit, if it was to the third.
std::optional<Matrix3d> as_rotation(const Matrix3d &matrix) {
    constexpr double rounding = 2e-3;
    if (!matrix.allFinite() || !(matrix.transpose() * matrix).isIdentity(rounding) || matrix.determinant() < 0.0)
        return std::nullopt;
    if ((matrix.transpose() * matrix).isIdentity(0.0))
        return matrix;
    const Eigen::JacobiSVD<Matrix3d> parts(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
    return Matrix3d(parts.matrixU() * parts.matrixV().transpose());
}

/// Axes by three lists of numbers; zero where they are something else.
Matrix3d listed(const toml::node &node) {
    Matrix3d columns = Matrix3d::Zero();
    const auto *rows = node.as_array();
    for (std::size_t r = 0; rows && rows->size() == 3 && r < 3; ++r)
        if (const auto *row = rows->get(r)->as_array(); row && row->size() == 3)
            for (std::size_t c = 0; c < 3; ++c)
                columns(static_cast<Eigen::Index>(c), static_cast<Eigen::Index>(r)) =
                    row->get(c)->value<double>().value_or(0.0);
    return columns;
}

} // namespace

SaidAxes read_axes(const toml::table &body) {
    SaidAxes said;
    if (const auto *image = body.get_as<toml::table>("image"))
        said.is_lps_by_header = (*image)["orientation"].value<std::string>() == "LPS";
    const auto *node = body.get("axes");
    if (!node)
        return said;
    const auto word = node->value<std::string>().value_or("");
    said.as_registered = word == "registered";
    said.is_unknown = word == "unknown";
    if (said.as_registered || said.is_unknown)
        return said;
    said.from_lps = as_rotation(node->is_string() ? lettered(word) : listed(*node));
    if (!said.from_lps)
        support::refuse(*node, "'axes' has to be three letters that say where x, y and z of the mesh lead to, such as "
                               "\"LPS\" or \"RAS\", and make no mirror; or the patient's left, posterior and superior "
                               "as three perpendicular directions of length 1; or \"registered\" or \"unknown\"");
    return said;
}

std::string axes_toml(const core::BodyAxes &axes) {
    if (!axes.doubt.empty())
        return "axes = \"unknown\" # write \"LPS\", or what is true\n";
    if (axes.from_lps.isIdentity(0.0))
        return "";
    const auto column = [&](int c) {
        return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", axes.from_lps(0, c), axes.from_lps(1, c),
                           axes.from_lps(2, c));
    };
    return fmt::format("axes = [{}, {}, {}] # left, posterior, superior\n", column(0), column(1), column(2));
}

core::BodyAxes body_axes(const core::TetraMesh &mesh, const std::optional<FoundPatches> &found, const SaidAxes &said,
                         std::vector<std::string> &remarks) {
    if (said.is_unknown)
        return {Matrix3d::Identity(), liver_patch_names(), "its .toml says that its axes are unknown"};
    auto from_lps = said.from_lps;
    if (const auto named = said.as_registered && !found ? fit_of_patches(mesh) : std::nullopt)
        from_lps = named->from_lps;
    if (said.as_registered && found)
        from_lps = found->from_lps;
    if (from_lps) {
        remarks.push_back(fmt::format(
            "the body is turned by {:.0f} degrees from LPS, as its .toml says{}; directions of load cases turn with it",
            turn_of(*from_lps),
            found ? fmt::format(", and was found turned by {:.0f}", turn_of(found->from_lps)) : ""));
        return {*from_lps, {}, {}};
    }
    return found ? registered(*found, said.is_lps_by_header, remarks) : axes_of_named_patches(mesh, remarks);
}

} // namespace livermark::meshes
