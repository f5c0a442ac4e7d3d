#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <map>
#include <numbers>
#include <numeric>
#include <sstream>

#include "meshes/io/body_reader.hpp"
#include "meshes/io/msh_writer.hpp"
#include "tests/livermark_command.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

using tests::livermark;

/// Printed with five digits.
constexpr double rounding = 1.1e-4;

/// A box, and the same box with a lump in it, as files; constrained at x_min.
class Parameters : public testing::Test {
  protected:
    void SetUp() override {
        const auto *test = testing::UnitTest::GetInstance()->current_test_info();
        folder_ = std::filesystem::path(testing::TempDir()) / "livermark_parameters" / test->name();
        std::filesystem::remove_all(folder_);
        std::filesystem::create_directories(folder_);
        auto mesh = tests::box_mesh({0.1, 0.08, 0.06}, {4, 3, 3});
        mesh.region_names = {"parenchyma"};
        write("plain", mesh);
        mesh.region_names.emplace_back("tumour_1");
        for (std::size_t t = 60; t < 90; ++t)
            mesh.region[t] = 1;
        write("lump", mesh);
        std::ofstream(folder_ / "held.toml") << "title = \"held\"\ntarget_peak_displacement = 0.001\n[[condition]]\n"
                                                "patch = \"x_min\"\ndisplacement = [0.0, 0.0, 0.0]\n";
    }

    std::filesystem::path body_file(const std::string &name) const { return folder_ / (name + ".toml"); }

    /// The cells of the Markdown tables, by the first cell of their row.
    std::map<std::string, std::vector<std::string>> cells(const std::string &body, const std::string &options = {}) {
        const auto outcome = livermark(arguments(body, options));
        EXPECT_EQ(outcome.status, 0) << outcome.output;
        text_ = outcome.output;
        std::map<std::string, std::vector<std::string>> rows;
        std::istringstream lines(outcome.output);
        for (std::string line; std::getline(lines, line);) {
            std::vector<std::string> row;
            std::istringstream stream(line.substr(0, line.rfind(" |")));
            for (std::string cell; line.starts_with("| ") && std::getline(stream, cell, '|');)
                if (const auto start = cell.find_first_not_of(' '); start != std::string::npos)
                    row.push_back(cell.substr(start, cell.find_last_not_of(' ') + 1 - start));
            if (!row.empty())
                rows.emplace(row.front(), std::vector(row.begin() + 1, row.end())); // the first of that name
        }
        return rows;
    }
    std::string arguments(const std::string &body, const std::string &options = {}) const {
        return fmt::format("parameters {} --markdown --load-case {} {}", body_file(body).string(),
                           (folder_ / "held.toml").string(), options);
    }
    const std::string &text() const { return text_; }

  private:
    void write(const std::string &name, const core::TetraMesh &mesh) {
        meshes::write_msh(folder_ / (name + ".msh"), mesh);
        std::ofstream toml(body_file(name));
        toml << "title = \"" << name << "\"\nmesh = \"" << name << ".msh\"\n";
        for (std::size_t r = 0; r < mesh.region_names.size(); ++r)
            toml << "[regions." << mesh.region_names[r] << "]\ndensity = " << (r == 0 ? 1000 : 1200)
                 << "\nyoung_modulus = " << (r == 0 ? 5000 : 20000) << "\npoisson_ratio = 0.25\nsource = \"test\"\n";
    }

    std::filesystem::path folder_;
    std::string text_;
};

constexpr const char *node_mass = "node mass [kg]";
constexpr const char *stiffness = "spring stiffness [N/m]";
constexpr const char *dashpot = "axial dashpot beta k [N s/m]";
constexpr const char *mass_damper = "mass damper alpha m [N s/m]";
constexpr const char *alpha = "damping alpha [1/s]";
constexpr const char *beta = "damping beta [s]";
constexpr const char *first_frequency = "first natural frequency [Hz]";
constexpr const char *largest_frequency = "largest angular frequency [rad/s]";
constexpr const char *critical_step = "critical time step of undamped Runge-Kutta 4 [s]";

void expect_close(double value, double expected) {
    EXPECT_NEAR(value / expected, 1.0, rounding) << value << " is not " << expected;
}

double value(const std::map<std::string, std::vector<std::string>> &rows, const char *name, std::size_t column = 0) {
    return std::stod(rows.at(name).at(column));
}

TEST_F(Parameters, HaveTheMassAndTheSpringsOfTheMesh) {
    for (const char *name : {"plain", "lump"}) {
        const auto body = meshes::read_body(body_file(name));
        const auto volumes = core::tetrahedron_volumes(body.mesh);
        double mass = 0.0;
        for (std::size_t t = 0; t < volumes.size(); ++t)
            mass += body.materials[body.mesh.region[t]].density * volumes[t];
        const auto rows = cells(name);
        EXPECT_EQ(value(rows, node_mass), body.mesh.num_nodes());
        expect_close(value(rows, node_mass, 1), mass);
        expect_close(value(rows, "mass [kg]"), mass);
        expect_close(value(rows, "volume [L]"), 1e3 * std::accumulate(volumes.begin(), volumes.end(), 0.0));
        EXPECT_EQ(value(rows, stiffness), static_cast<double>(core::edge_table(body.mesh.tetrahedra).edges.size()));
    }
}

TEST_F(Parameters, DampingIsOfTheKindThatWasAskedFor) {
    const auto by_mass = cells("plain", "--damping mass --damping-ratio 0.1");
    const double first = 2.0 * std::numbers::pi * value(by_mass, first_frequency);
    expect_close(value(by_mass, alpha), 2.0 * 0.1 * first);
    EXPECT_EQ(value(by_mass, dashpot, 1), 0.0);
    const auto by_stiffness = cells("plain", "--damping stiffness --damping-ratio 0.1");
    expect_close(value(by_stiffness, beta), 2.0 * 0.1 / first);
    EXPECT_EQ(value(by_stiffness, mass_damper, 1), 0.0);
    const double omega = 2.0 * std::numbers::pi * 9.0;
    const auto by_both = cells("plain", "--damping-frequencies 2 9 --damping-ratio 0.1");
    expect_close(0.5 * (value(by_both, alpha) / omega + value(by_both, beta) * omega), 0.1);
}

TEST_F(Parameters, FollowYoungsModulus) {
    const auto soft = cells("lump", "--law lloyd");
    const auto stiff = cells("lump", "--young 20000"); // four times as stiff, the lump too
    expect_close(value(stiff, stiffness, 1), 4.0 * value(soft, stiffness, 1));
    expect_close(value(stiff, first_frequency), 2.0 * value(soft, first_frequency));
    expect_close(value(stiff, critical_step), 0.5 * value(soft, critical_step));
    expect_close(value(soft, critical_step) * value(soft, largest_frequency), std::sqrt(8.0));
    EXPECT_NE(value(cells("lump", "--law lloyd_edge"), stiffness, 1), value(soft, stiffness, 1));
}

/// The body's own parameters and those of the mesh without its lump stand side by side.
TEST_F(Parameters, SayWhatTumoursDo) {
    const auto plain = cells("plain");
    EXPECT_EQ(text().find("Effect of the tumours"), std::string::npos);
    const auto lump = cells("lump");
    EXPECT_NE(text().find("Effect of the tumours"), std::string::npos);
    const auto &sum = lump.at("sum of spring stiffnesses [N/m]");
    expect_close(std::stod(sum[0]), value(plain, stiffness, 1));
    expect_close(std::stod(sum[1]), value(lump, stiffness, 1));
    EXPECT_NEAR(std::stod(sum[2]), 100.0 * (std::stod(sum[1]) / std::stod(sum[0]) - 1.0), 0.02);
    const auto &mode = lump.at("frequency of mode 1 [Hz]");
    expect_close(std::stod(mode[0]), value(plain, first_frequency));
    expect_close(std::stod(mode[1]), value(lump, first_frequency));
}

/// The sentences beside the paper's numbers come from the numbers of the body.
TEST_F(Parameters, ObjectToThePaperWhereTheNumbersDo) {
    cells("plain");
    EXPECT_NE(text().find("mass 1.9825 kg: can be."), std::string::npos) << text();
    EXPECT_NE(text().find("stiffness 5.4225 kPa: does not follow. A spring stiffness is in N/m"), std::string::npos);
    EXPECT_NE(text().find("near the mean Young's modulus"), std::string::npos) << text();
    cells("plain", "--young 50000");
    EXPECT_EQ(text().find("near the mean Young's modulus"), std::string::npos) << text();
    cells("lump");
    EXPECT_NE(text().find("mass 5.9256 kg: does not follow. At this body's"), std::string::npos) << text();
    EXPECT_NE(text().find("stiffness 7.0484 kPa"), std::string::npos) << text();
}

TEST_F(Parameters, AreRefusedWithStatusTwoWhereTheInputIsBad) {
    for (const auto &[options, message] : {
             std::pair{"--law loyd", "did you mean 'lloyd'?"},
             {"--law xyzzyxyzzy", "there is no spring law 'xyzzyxyzzy'; known are: lloyd"},
             {"--damping magic", "--damping"},
             {"--damping-ratio -1", "the damping ratio is -1; it has to be zero or more"},
             {"--damping-ratio nan", "it has to be zero or more"},
             {"--damping-frequencies 2 2", "frequencies that differ"},
             {"--damping-frequencies 0 2", "has to be positive"},
             {"--damping-frequencies 2", "--damping-frequencies"},
             {"--damping mass --damping-frequencies 1 2", "for --damping rayleigh"},
             {"--young -5", "Young's modulus is -5 Pa"},
             {"--poisson 0.5", "between -1 and 0.5"},
         }) {
        const auto outcome = livermark(arguments("plain", options));
        EXPECT_EQ(outcome.status, 2) << options << "\n" << outcome.output;
        EXPECT_NE(outcome.output.find(message), std::string::npos) << options << "\n" << outcome.output;
    }
    EXPECT_EQ(livermark("parameters liver_healty").status, 2);
    EXPECT_EQ(livermark("parameters liver_healthy --load-case tracton").status, 2);
}

} // namespace
} // namespace livermark
