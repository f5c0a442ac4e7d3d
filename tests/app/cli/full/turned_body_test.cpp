#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <string>
#include <utility>
#include <vector>

#include "meshes/io/mesh_files.hpp"
#include "results/hdf5/result_file.hpp"
#include "results/tables/tool_cells.hpp"
#include "tests/child.hpp"
#include "tests/result_folder.hpp"

namespace livermark {
namespace {

namespace fs = std::filesystem;

/// The healthy liver in other axes than the patient's.
class TurnedBody : public tests::ResultFolder {
  protected:
    /// @param is_named  whether the file has the names of the patches
    void write_liver(const std::string &name, const core::Vector3 &turn, bool is_named) const {
        auto mesh = meshes::read_msh(LIVERMARK_SOURCE_DIR "/meshes/liver_healthy.msh");
        const Eigen::AngleAxisd rotation(turn.norm(), turn.norm() > 0.0 ? turn.normalized() : core::Vector3::UnitX());
        for (auto &point : mesh.points)
            point = rotation * point;
        if (!is_named) {
            mesh.patch_names = {"surface"};
            std::ranges::fill(mesh.boundary_patch, 0);
        }
        meshes::write_msh(directory_ / (name + ".msh"), mesh);
        std::ofstream(directory_ / (name + ".toml"))
            << fmt::format("mesh = \"{}.msh\"\nfind_patches = true\n[regions.parenchyma]\ndensity = 1060.0\n"
                           "young_modulus = 5000.0\npoisson_ratio = 0.45\n",
                           name);
    }

    tests::ChildEnd run(std::vector<std::string> bodies) const {
        std::vector<std::string> words{LIVERMARK_BINARY, "run",      "--static", "--reference-on-mesh", "--model",
                                       "fem_p1",         "--output", "runs",     "--load-case",         "breathing",
                                       "gravity_tilt",   "traction", "--body"};
        words.insert(words.end(), bodies.begin(), bodies.end());
        return tests::run_child(words, {.folder = directory_});
    }

    /// Both columns of the table [%].
    std::pair<double, double> numbers(const std::string &body, const std::string &load_case) const {
        const auto result = results::read_result(directory_ / "runs" / body / (load_case + ".h5"));
        const auto model = std::ranges::find(result.models, "fem_p1", &results::ModelResult::name);
        return {100.0 * model->comparison->relative_l2, 100.0 * results::stiffness_at_tool(*model)};
    }
};

TEST_F(TurnedBody, HasTheTableOfTheOneInLps) {
    const core::Vector3 by_97_degrees(1.69, 0.0, 0.0);
    write_liver("named", {0.0, 0.0, 0.0}, true);
    write_liver("named_turned", by_97_degrees, true);
    write_liver("plain", {0.0, 0.0, 0.0}, false);
    write_liver("plain_turned", by_97_degrees, false);
    const auto end = run({"named.toml", "named_turned.toml", "plain.toml", "plain_turned.toml"});
    ASSERT_EQ(end.status, 0) << end.errors;
    for (const std::string body : {"named", "plain"}) {
        EXPECT_NE(end.errors.find(body + "_turned: "), std::string::npos) << end.errors;
        for (const std::string load_case : {"breathing", "gravity_tilt", "traction"}) {
            const auto [l2, tool] = numbers(body, load_case);
            const auto [turned_l2, turned_tool] = numbers(body + "_turned", load_case);
            fmt::print("{} {}: L2 {:.3f} and {:.3f} %, tool {:.3f} and {:.3f} %\n", body, load_case, l2, turned_l2,
                       tool, turned_tool);
            const double most =
                body == "named" ? 0.05 : 0.5; // percentage points, of rotations found by patches, by shape
            EXPECT_NEAR(turned_l2, l2, most) << body << " " << load_case;
            EXPECT_EQ(std::isnan(turned_tool), std::isnan(tool)) << load_case;
            if (!std::isnan(tool)) { // as without a place that is loaded
                EXPECT_NEAR(turned_tool, tool, most) << body << " " << load_case;
            }
        }
    }
    EXPECT_NE(end.errors.find("turned by 97 degrees from LPS"), std::string::npos) << end.errors;
}

} // namespace
} // namespace livermark
