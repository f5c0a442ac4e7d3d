#include <algorithm>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <regex>

#include "meshes/io/mesh_figures.hpp"
#include "results/hdf5/result_file.hpp"
#include "support/whole_file.hpp"

#include "tests/child.hpp"

namespace livermark {
namespace {

namespace fs = std::filesystem;
using core::Vector3;

/// A field at a place, from the tetrahedron in which it lies deepest, or outside of the body least far.
Vector3 field_at(const core::TetraMesh &mesh, const std::vector<Vector3> &field, const Vector3 &place) {
    double deepest = -INFINITY;
    Vector3 value = Vector3::Zero();
    for (const auto &t : mesh.tetrahedra) {
        std::array<Vector3, 4> corner;
        for (std::size_t c = 0; c < 4; ++c)
            corner.at(c) = mesh.points[static_cast<std::size_t>(t.at(c))];
        if ((corner[0] - place).squaredNorm() > 0.03 * 0.03)
            continue;
        const double volume = core::signed_volume(corner[0], corner[1], corner[2], corner[3]);
        std::array<double, 4> weight{};
        for (std::size_t c = 0; c < 4; ++c) {
            auto moved = corner;
            moved.at(c) = place;
            weight.at(c) = core::signed_volume(moved[0], moved[1], moved[2], moved[3]) / volume;
        }
        if (const double depth = *std::ranges::min_element(weight); depth > deepest) {
            deepest = depth;
            value.setZero();
            for (std::size_t c = 0; c < 4; ++c)
                value += weight.at(c) * field[static_cast<std::size_t>(t.at(c))];
        }
    }
    return value;
}

const core::Solution &reference_of(const results::Result &result) {
    return std::ranges::find(result.models, result.reference_uncertainty->reference, &results::ModelResult::name)
        ->solution;
}

/// Size of the whole force that holds the body [N].
double constrained_force(const results::Result &result) {
    Vector3 sum = Vector3::Zero();
    for (const auto &reaction : reference_of(result).reaction)
        sum += reaction;
    return sum.norm();
}

std::vector<Vector3> carried(const core::TetraMesh &from, const std::vector<Vector3> &field,
                             const core::TetraMesh &to) {
    std::vector<Vector3> result;
    for (const auto &place : to.points)
        result.push_back(field_at(from, field, place));
    return result;
}

/// Relative L2 distance of two fields at the nodes of a mesh.
double distance(const core::TetraMesh &mesh, const std::vector<Vector3> &field, const std::vector<Vector3> &expected) {
    const auto volumes = core::nodal_volumes(mesh);
    double apart = 0.0, size = 0.0;
    for (std::size_t i = 0; i < volumes.size(); ++i) {
        apart += volumes[i] * (field[i] - expected[i]).squaredNorm();
        size += volumes[i] * expected[i].squaredNorm();
    }
    return std::sqrt(apart / size);
}

/// Of the references, over the nodes of the second result.
double distance(const results::Result &from, const results::Result &to) {
    const auto &mesh = to.problem.body->mesh;
    return distance(mesh, reference_of(to).displacement,
                    carried(from.problem.body->mesh, reference_of(from).displacement, mesh));
}

/// What a field loses on its way from the nodes of one mesh to those of the other: half of what it loses there and
/// back.
double interpolation_error(const results::Result &from, const results::Result &to) {
    const auto &mesh = to.problem.body->mesh, &other = from.problem.body->mesh;
    const auto &field = reference_of(to).displacement;
    return 0.5 * distance(mesh, carried(other, carried(mesh, field, other), mesh), field);
}

/// The liver with tumours as it ships, but for its patches: their names are changed, so that the rules find them anew.
void write_direct_body(const fs::path &folder) {
    const fs::path meshes = LIVERMARK_SOURCE_DIR "/meshes";
    std::ofstream(folder / "direct.msh") << std::regex_replace(support::read_text(meshes / "liver_tumours.msh"),
                                                               std::regex("\n2 (\\d+) \""), "\n2 $1 \"drawn_");
    auto toml = support::read_text(meshes / "liver_tumours.toml");
    toml.erase(toml.find("[patches"));
    std::ofstream(folder / "direct.toml")
        << std::regex_replace(toml, std::regex("mesh = .*"), "mesh = \"direct.msh\"\nfind_patches = true");
}

TEST(WholeWay, FromAnImageToDisplacementsAgreesWithTheMeshOfTheSameShape) {
    const auto folder = fs::path(testing::TempDir()) / "livermark_whole_way";
    fs::remove_all(folder);
    fs::create_directories(folder);
    write_direct_body(folder);
    const auto livermark = [&](std::vector<std::string> words) {
        words.insert(words.begin(), LIVERMARK_BINARY);
        const auto end = tests::run_child(words, {.folder = folder});
        EXPECT_EQ(end.status, 0) << end.errors;
    };
    livermark({"mesh", "--phantom", "-o", "phantom.nii.gz"});
    livermark({"run", "--body", "phantom.nii.gz", "direct.toml", "--load-case", "gravity_tilt", "traction", "--model",
               "lloyd", "--output", "runs"});
    for (const char *load_case : {"gravity_tilt.h5", "traction.h5"}) {
        SCOPED_TRACE(load_case);
        const auto scanned = results::read_result(folder / "runs" / "phantom" / load_case);
        const auto direct = results::read_result(folder / "runs" / "direct" / load_case);
        EXPECT_TRUE(scanned.problem.body->assumptions.front().starts_with("made of the segmentation phantom.nii.gz"));
        EXPECT_TRUE(scanned.problem.body->assumptions.back().starts_with("the body is in LPS, as the header of its "
                                                                         "file says"))
            << scanned.problem.body->assumptions.back();
        const double volume = meshes::mesh_figures(direct.problem.body->mesh).volume;
        // Facets cut the corners of a round shape, and bending goes with the third power of how thick a lobe is; what
        // is pulled ends where a facet ends.
        const double geometric =
            3.0 * std::abs(meshes::mesh_figures(scanned.problem.body->mesh).volume / volume - 1.0) +
            std::abs(constrained_force(scanned) / constrained_force(direct) - 1.0);
        const double uncertainty =
            scanned.reference_uncertainty->relative_l2 + direct.reference_uncertainty->relative_l2;
        const double interpolation = interpolation_error(direct, scanned);
        const double apart = distance(direct, scanned);
        EXPECT_LT(apart, uncertainty + geometric + interpolation);
        RecordProperty(fmt::format("{}_percent", load_case),
                       fmt::format("{:.2f} of {:.2f} + {:.2f} + {:.2f}", 100.0 * apart, 100.0 * uncertainty,
                                   100.0 * geometric, 100.0 * interpolation));
        fmt::print("{}: {:.2f} % apart, uncertainty {:.2f} %, geometry {:.2f} %, interpolation {:.2f} %\n", load_case,
                   100.0 * apart, 100.0 * uncertainty, 100.0 * geometric, 100.0 * interpolation);
    }
}

} // namespace
} // namespace livermark
