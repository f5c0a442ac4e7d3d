#pragma once

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <string>

#include "meshes/generators/box_generator.hpp"
#include "meshes/io/mesh_files.hpp"

namespace livermark::tests {

/// A small bar as the body of a user, in a folder of the test's own, so that commands that run on it do not take long.
/// @param suite  of the tests, for the name of the folder
/// @param edge   of its tetrahedra [m]
/// @return the folder, with bar.toml and bar.msh
inline std::filesystem::path folder_with_bar(const std::string &suite, double edge = 0.02) {
    auto folder = std::filesystem::path(testing::TempDir()) / ("livermark_" + suite) /
                  testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    meshes::write_msh(folder / "bar.msh", meshes::generate_box({0.09, 0.03, 0.03}, edge));
    std::ofstream(folder / "bar.toml")
        << "title = \"bar\"\nmesh = \"bar.msh\"\n[regions.solid]\ndensity = 1000.0\nyoung_modulus = 5000.0\n"
           "poisson_ratio = 0.3\nsource = \"made up\"\n";
    return folder;
}

} // namespace livermark::tests
