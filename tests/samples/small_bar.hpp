#pragma once

#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <string>

#include "meshes/generators/box_generator.hpp"
#include "meshes/io/mesh_files.hpp"

namespace livermark::tests {

/// Poisson's ratio that is so near 1/2 that the reference has pressures, and solves load cases together.
inline constexpr double pressure_ratio = 0.45;

inline void write_bar_body(const std::filesystem::path &folder, double poisson_ratio) {
    std::ofstream(folder / "bar.toml") << fmt::format(
        "title = \"bar\"\nmesh = \"bar.msh\"\n[regions.solid]\ndensity = 1000.0\nyoung_modulus = 5000.0\n"
        "poisson_ratio = {}\nsource = \"made up\"\n",
        poisson_ratio);
}

/// A small bar as the body of a user, in a folder of the test's own, so that commands that run on it do not take long.
/// @param suite  of the tests, for the name of the folder
/// @param edge   of its tetrahedra [m]
/// @return the folder, with bar.toml and bar.msh
inline std::filesystem::path folder_with_bar(const std::string &suite, double edge = 0.02, double poisson_ratio = 0.3) {
    auto folder = std::filesystem::path(testing::TempDir()) / ("livermark_" + suite) /
                  testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    meshes::write_msh(folder / "bar.msh", meshes::generate_box({0.09, 0.03, 0.03}, edge));
    write_bar_body(folder, poisson_ratio);
    return folder;
}

/// A load case that holds the bar at one end and pulls at the other, <name>.toml in its folder.
/// @param traction  [Pa]
/// @param more      lines in front of its conditions
/// @return the path
inline std::string write_pull(const std::filesystem::path &folder, const std::string &name = "pull",
                              double traction = 10.0, const std::string &more = "") {
    auto path = (folder / (name + ".toml")).string();
    std::ofstream(path) << fmt::format(
        "title = \"pull\"\ntarget_peak_displacement = 0.001\n{}[[condition]]\npatch = \"x_min\"\n"
        "displacement = [0.0, 0.0, 0.0]\n[[condition]]\npatch = \"x_max\"\ntraction = [{}, 0.0, 0.0]\n",
        more, traction);
    return path;
}

} // namespace livermark::tests
