#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <string>

#include "core/support/files.hpp"
#include "meshes/io/vessel_files.hpp"
#include "results/hdf5/result_file.hpp"
#include "tests/livermark_command.hpp"
#include "tests/result_folder.hpp"

namespace livermark {
namespace {

namespace fs = std::filesystem;

/// `livermark mesh vessels` in a folder.
class VesselsOfAnImage : public tests::ResultFolder {
  protected:
    tests::Outcome in_folder(const std::string &arguments) const {
        return tests::run_command(fmt::format("cd {} && {} {}", directory_.string(), LIVERMARK_BINARY, arguments));
    }
    void write_phantom() const {
        tests::expect_outcome(
            in_folder("mesh --phantom --vessels --spacing 0.0015 0.0015 0.003 --turn 0.1 0.2 -0.1 -o seg.nrrd"), 0, {});
    }
    core::VesselTree lines(const std::string &name) const { return meshes::read_swc(directory_ / name, 1.0); }
};

TEST_F(VesselsOfAnImage, AreWrittenAsLines) {
    write_phantom();
    tests::expect_outcome(in_folder("mesh vessels seg.nrrd -o veins.swc"), 0,
                          {"veins.swc: ", " branches of 0.3", "of labels 8 'Hepatic vein', 9 'Portal vein'",
                           "[vessels]\nfile = \"veins.swc\"\nunit = \"m\"\n"});
    const auto text = support::read_text(directory_ / "veins.swc");
    EXPECT_NE(text.find("# lines of the vessels of seg.nrrd, in metres"), std::string::npos) << text.substr(0, 200);
    const auto veins = lines("veins.swc");
    EXPECT_NEAR(meshes::length_of(veins), 0.31, 0.03);
    EXPECT_GT(*std::ranges::min_element(veins.radius), 0.0025);
    EXPECT_LT(*std::ranges::max_element(veins.radius), 0.0065);

    tests::expect_outcome(in_folder("mesh vessels seg.nrrd --largest-radius 0.0045"), 0, {"seg.swc: "});
    const auto thin = lines("seg.swc");
    EXPECT_LT(meshes::length_of(thin), 0.8 * meshes::length_of(veins));
    EXPECT_LE(*std::ranges::max_element(thin.radius), 0.0045 + 1e-6);

    tests::expect_outcome(in_folder("mesh vessels seg.nrrd --role 'hepatic vein=ignore' -o portal.swc"), 0,
                          {"of label 9 'Portal vein'"});
    EXPECT_LT(meshes::length_of(lines("portal.swc")), 0.7 * meshes::length_of(veins));
}

/// The way of docs/howto/from_segmentation_to_table.md, with a capsule beside the veins.
TEST_F(VesselsOfAnImage, GoWithTheBodyToATableAndAReport) {
    write_phantom();
    tests::expect_outcome(in_folder("mesh --labels seg.nrrd --tetrahedra 8000 -o patient.msh"), 0, {});
    tests::expect_outcome(in_folder("mesh vessels seg.nrrd --largest-radius 0.008 -o patient.swc"), 0, {});
    std::ofstream(directory_ / "patient.toml", std::ios::app)
        << "\n[vessels]\nfile = \"patient.swc\"\nunit = \"m\"\n[capsule]\nthickness = 20e-6\nyoung_modulus = 8.22e6\n";
    tests::expect_outcome(in_folder("run --body patient.toml --load-case palpation --static --reference-on-mesh "
                                    "--model lloyd nodal_neo_hookean --output runs"),
                          0, {"vessels of patient.swc are lines of", "a capsule of 20 um and 8.22 MPa covers it"});
    const auto result = results::read_result(directory_ / "runs" / "patient" / "palpation.h5");
    EXPECT_TRUE(result.problem.body->vessels && result.problem.body->capsule);
    for (const auto &model : result.models)
        EXPECT_EQ(model.solution.status, core::SolutionStatus::ok) << model.name;
    tests::expect_outcome(in_folder("report runs -o report.html"), 0, {});
    const auto page = support::read_text(directory_ / "report.html");
    EXPECT_NE(page.find("vessels of patient.swc are lines of"), std::string::npos);
    EXPECT_NE(page.find("a capsule of 20 um"), std::string::npos);
    tests::expect_outcome(in_folder("advise patient.toml"), 0, {"ligaments in place of a held back"});
}

TEST_F(VesselsOfAnImage, AreRefusedWhereItHasNone) {
    written("plain.nrrd", "NRRD0004\ntype: uchar\ndimension: 3\nspace: left-posterior-superior\nsizes: 3 2 2\n"
                          "space directions: (2,0,0) (0,2,0) (0,0,2)\nspace origin: (0,0,0)\nencoding: ascii\n\n"
                          "0 1 2 0 1 2 0 1 2 0 1 2\n");
    tests::expect_outcome(in_folder("mesh vessels plain.nrrd -o lines.swc"), 2,
                          {"plain.nrrd: none of its labels is a vessel of the liver by its name: 1, 2;",
                           "such as --role 2=vessel_portal"});
    tests::expect_outcome(in_folder("mesh vessels plain.nrrd --role 3=vessel -o lines.swc"), 2,
                          {"--role names '3', which is no segment and no label of it; it has 1, 2"});
    tests::expect_outcome(in_folder("mesh vessels plain.nrrd --role 2=vessel -o lines.swc"), 2,
                          {"label 2 has no line: it is shorter than 10 mm", "no line is left of its vessels, 2"});
    tests::expect_outcome(in_folder("mesh vessels plain.nrrd --role 2=vessel -o lines.vtk"), 2,
                          {"end its name in .swc"});
    tests::expect_outcome(in_folder("mesh vessels plain.nrrd --role 2=vessel --largest-radius 4 -o lines.swc"), 2,
                          {"--largest-radius is 4 m; give a length below 0.1 m"});
    EXPECT_FALSE(fs::exists(directory_ / "lines.swc"));
}

} // namespace
} // namespace livermark
