#include <filesystem>
#include <functional>
#include <gtest/gtest.h>

#include "core/support/input_error.hpp"
#include "core/support/toml_input.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "meshes/io/mesh_files.hpp"
#include "studies/exchange/formats/export_format.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

/// Seeds that the fuzzers start from, and inputs that they have found: every file is read or refused.
int num_read(const std::string &reader, const std::function<void(const std::filesystem::path &)> &read) {
    int count = 0;
    for (const auto &entry : std::filesystem::directory_iterator(LIVERMARK_SOURCE_DIR "/tests/fuzz/seeds/" + reader))
        try {
            read(entry.path());
            ++count;
        } catch (const support::InputError &error) {
            EXPECT_FALSE(std::string(error.what()).empty());
        }
    return count;
}

TEST(FuzzSeeds, AreReadOrRefused) {
    const auto mesh = tests::box_mesh({0.1, 0.1, 0.1}, {2, 2, 2});
    EXPECT_GE(num_read("msh", [](const auto &file) { meshes::read_msh(file); }), 2);
    EXPECT_GE(num_read("load_case", [&](const auto &file) { load_cases::read_load_case(file, mesh); }), 3);
    EXPECT_GE(num_read("solution", [](const auto &file) { studies::read_outside_solution(file); }), 1);
}

} // namespace
} // namespace livermark
