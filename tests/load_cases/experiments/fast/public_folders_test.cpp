#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <optional>
#include <string>
#include <utility>

#include "load_cases/experiments/experiment.hpp"
#include "tests/bad_input.hpp"
#include "tests/result_folder.hpp"

namespace livermark::experiments {
namespace {

namespace fs = std::filesystem;

/// An environment variable with another value, or without one, until the end of a test.
class OtherVariable {
  public:
    OtherVariable(std::string name, const std::string &value) : name_(std::move(name)) {
        if (const char *before = std::getenv(name_.c_str()))
            before_ = before;
        set(value);
    }
    ~OtherVariable() { set(before_.value_or("")); }
    OtherVariable(const OtherVariable &) = delete;
    OtherVariable &operator=(const OtherVariable &) = delete;

    void set(const std::string &value) const {
        if (value.empty())
            unsetenv(name_.c_str());
        else
            setenv(name_.c_str(), value.c_str(), 1);
    }

  private:
    std::string name_;
    std::optional<std::string> before_;
};

struct PublicFolders : tests::ResultFolder {
    OtherVariable named_{"LIVERMARK_EXPERIMENTS", ""}, data_home_{"XDG_DATA_HOME", ""}, home_{"HOME", ""};

    /// A folder with the measured needle.
    fs::path with_needle(const fs::path &folder) const {
        fs::create_directories(folder / "needle");
        std::ofstream(folder / "needle" / "depth_force.csv") << "0,0\n";
        return folder;
    }
};

TEST_F(PublicFolders, AreTheGivenOneThenTheNamedOneThenThatOfTheUser) {
    const std::string needle = "needle/depth_force.csv";
    EXPECT_TRUE(data_folders().empty());
    EXPECT_FALSE(public_data(needle).has_value());
    home_.set((directory_ / "home").string());
    const auto own = with_needle(directory_ / "home" / ".local" / "share" / "livermark" / "experiments");
    EXPECT_EQ(public_data(needle), own / needle);
    data_home_.set((directory_ / "data").string());
    const auto below_data_home = directory_ / "data" / "livermark" / "experiments";
    EXPECT_EQ(data_folders(), std::vector<fs::path>{below_data_home});
    EXPECT_FALSE(public_data(needle).has_value());
    with_needle(below_data_home);
    EXPECT_EQ(public_data(needle), below_data_home / needle);
    named_.set((directory_ / "named").string());
    EXPECT_EQ(public_data(needle), below_data_home / needle); // nothing is in the named one
    with_needle(directory_ / "named");
    EXPECT_EQ(public_data(needle), directory_ / "named" / needle);
    EXPECT_EQ(public_data(needle, directory_ / "given"), directory_ / "named" / needle);
    const auto given = with_needle(directory_ / "given");
    EXPECT_EQ(public_data(needle, given), given / needle);
    EXPECT_EQ(data_folders(given), (std::vector<fs::path>{given, directory_ / "named", below_data_home}));
    data_home_.set("a/relative/one"); // which the specification ignores
    EXPECT_EQ(data_folders().back(), own);
}

TEST_F(PublicFolders, WithoutDataSayWhereToGetThemAndWhereToPutThem) {
    const auto &experiment = all_public_data().front();
    tests::expect_input_error(
        [&] { read_public(experiment); },
        {experiment.source, "LIVERMARK_EXPERIMENTS to the folder that " + experiment.data, "--data"});
    home_.set((directory_ / "home").string());
    tests::expect_input_error(
        [&] { read_public(experiment); },
        {"put " + experiment.data + " into " + (directory_ / "home/.local/share/livermark/experiments").string()});
}

TEST(PublicExperiments, HaveALicenceAndTheDigestsOfTheirFiles) {
    for (const auto &experiment : all_public_data()) {
        EXPECT_FALSE(experiment.licence.empty()) << experiment.name;
        EXPECT_FALSE(experiment.files.empty()) << experiment.name;
        for (const auto &file : experiment.files) {
            EXPECT_TRUE(file.path.starts_with(experiment.data)) << file.path;
            EXPECT_EQ(file.sha256.size(), 64U) << file.path;
            EXPECT_TRUE(std::ranges::all_of(file.sha256, [](unsigned char c) { return std::isxdigit(c) != 0; }));
        }
    }
}

} // namespace
} // namespace livermark::experiments
