#pragma once

#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <string>
#include <vector>

namespace livermark::tests {

/// An empty directory for each test, and a path in it.
class ResultFolder : public testing::Test {
  protected:
    void SetUp() override {
        const auto *test = testing::UnitTest::GetInstance()->current_test_info();
        directory_ = std::filesystem::path(testing::TempDir()) /
                     fmt::format("livermark_{}_{}", test->test_suite_name(), test->name());
        std::filesystem::remove_all(directory_);
        std::filesystem::create_directories(directory_);
        path_ = directory_ / "result.h5";
    }
    void TearDown() override { std::filesystem::remove_all(directory_); }

    std::vector<std::string> files() const {
        std::vector<std::string> names;
        for (const auto &entry : std::filesystem::directory_iterator(directory_))
            names.push_back(entry.path().filename());
        return names;
    }

    /// A file in the directory with these bytes.
    std::filesystem::path written(const std::string &name, const std::string &bytes) const {
        std::ofstream(directory_ / name, std::ios::binary) << bytes;
        return directory_ / name;
    }

    std::filesystem::path directory_;
    std::filesystem::path path_;
};

} // namespace livermark::tests
