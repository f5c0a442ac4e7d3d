#include <fstream>

#include "results/hdf5/result_file.hpp"
#include "tests/app/cli/bad_inputs/bad_inputs.hpp"
#include "tests/samples/records/sample_result.hpp"

namespace livermark::tests {

namespace {

namespace fs = std::filesystem;

/// A folder with a file of each kind.
void write_files(const fs::path &folder) {
    write_bar(folder);
    results::write_result(folder / "result.h5", sample_result());
    fs::create_directory(folder / "runs");
    results::write_result(folder / "runs" / "result.h5", sample_result());
}

/// A command on the bar, of which something may not be touched.
BadInput without_rights(std::string what, std::string arguments, const std::string &forbidden) {
    return {std::move(what),
            std::move(arguments),
            {{"case.toml", good_case}, {"two.msh", good_msh}, {"solution.csv", "x,y,z,ux,uy,uz\n"}},
            [=](const fs::path &folder) {
                write_files(folder);
                fs::create_directory(folder / "locked");
                const auto rights = forbidden == "locked" ? fs::perms::owner_read | fs::perms::owner_exec |
                                                                fs::perms::others_read | fs::perms::others_exec
                                                          : fs::perms::none;
                fs::permissions(folder / forbidden, rights);
            },
            {.without_rights = true}};
}

BadInput place(std::string what, std::string arguments) {
    return {std::move(what),
            std::move(arguments),
            {{"case.toml", good_case}, {"a_file", "in the way"}},
            [](const fs::path &folder) {
                write_files(folder);
                fs::create_directories(folder / "folder" / "bar");
            }};
}

BadInput full(BadInput row) {
    row.how.largest_file = 3000; // less than anything that is written
    return row;
}

BadInput to_full_output(BadInput row) {
    row.how.output = "/dev/full";
    return row;
}

} // namespace

std::vector<BadInput> bad_command_lines() {
    std::vector<BadInput> rows;
    const auto add = [&](const std::string &arguments) -> BadInput & {
        return rows.emplace_back(BadInput{"`livermark" + (arguments.empty() ? "" : " " + arguments) + "`", arguments});
    };
    // On a bar and a load case that let everything else be right.
    const auto add_on_bar = [&](const std::string &arguments) {
        auto &row = add(arguments);
        row.files["case.toml"] = good_case;
        row.prepare = write_bar;
    };
    for (const auto *arguments :
         {"",
          "rnu",
          "mesh chek",
          "mesh",
          "run --modle lloyd",
          "run --frobnicate",
          "run --young",
          "run --young 5000 --young 6000",
          "cohort --bodies 2 --output cohort extra",
          "score beam",
          "run --young soft",
          "list",
          "list model",
          "cohort --bodies 0 --output cohort",
          "cohort --bodies 8-1 --output cohort",
          "cohort --bodies 1-3,2 --output cohort",
          "cohort --bodies 1-1001 --output cohort",
          "cohort --bodies 1 --model loyd --output cohort",
          "run --sweep lloyd.a=0.1",
          "run --sweep nodal_springs.a=0.1,0",
          "run --no-uncertainty",
          "cohort --bodies 1 --output cohort --no-uncertainty",
          "score beam beam_bend solution.csv --no-uncertainty",
          "table --kind overviev",
          "report --ouptut report.html",
          "run --regime lagre",
          "needle --regime lagre",
          "needle --measured --regime large",
          "needle --measured time_forse",
          "needle --measured --data nowhere",
          "needle --data .",
          "needle --measured depth_force --rate 0.004",
          "needle --measured --rate 4",
          "experiment --list --data nowhere",
          "needle --regime large --model fem_p2p1_refined",
          "arena --tool gluede",
          "reference --model fem_p2_neo_hooke",
          "mesh box --size 1 1 1 --edge 1 -o box.vtk",
          "mesh liver -o liver.txt",
          "mesh --phantom --turn 0 nan 0 -o phantom.nii.gz",
          "mesh box --size 1 1 1 --edge 1e-5 -o box.msh",
          "mesh box --size 1e300 1e300 1e300 --edge 1e299 -o box.msh",
          "view --port 70000",
          "run --fem-solver magic",
          "run --body liver_healty",
          "run --load-case palpatoin",
          "run --load-case press_and_slide",
          "modes --load-case press_and_slide",
          "modes --load-case biopsy",
          "arena --load-case palpation",
          "needle --load-case palpation_at_1_hz",
          "run --body beam --young 1e300",
          "run --model loyd",
          "run --model xyzzyxyzzy",
          "run --body beam --body beam",
          "run --body beam --young -5",
          "run --body beam --young nan",
          "run --body beam --poisson 0.5",
          "run --body beam --poisson 0.49999999",
          "run --body beam --poisson nan",
          "run --amplitude 0",
          "run --amplitude 1,-1",
          "run --amplitude much",
          "advise",
          "advise beam --tool-radius 12",
          "advise beam liver_healthy",
          "arena --tool touching --solve-reference --output out",
          "arena --friction 0.3 --method lloyd --output out",
          "arena --tool touching --friction -1 --method lloyd --output out",
          "arena --tool needle --solve-reference --output out",
          "arena --tool needle --friction 0.3 --output out",
          "arena --tool needle --method nodal_neo_hookean_mass_scaled --output out",
          "arena --tool needle --load-case biopsy --body liver_tumours --needle tumour_9 --output out",
          "arena --tool needle --load-case press_and_slide --output out",
          "arena --tool needle --speed 0 --output out",
          "arena --tool needle --speed 100 --output out",
          "arena --speed 10 --method lloyd --output out",
          "score beam beam_bend solution.csv --name fem_p1 --output out",
          "score beam beam_bend solution.csv --name a/b --output out",
          "score beam beam_bend",
          "score --entry entry.toml beam",
          "export --board 7 beam",
          "export beam palpatoin",
          "export beam beam_bend --format vtk",
          "run --jobs 0",
          "run --time-step -1"})
        add(arguments);
    add_on_bar(good_run + " --integrator rk4");
    add_on_bar(good_run + " --equilibrium relaxation --integrator implicit_euler");
    add_on_bar(good_run + " --equilibrium relaxation --integrator runge_kutta_chebyshev");
    for (const auto *arguments :
         {"run --model calibrated_nodal_volume", "modes --model fem_p2p1", "modes --model fem_p1 --model fem_p1",
          "modes --count 0", "modes --load-case tracton", "stability --law loyd"})
        add(arguments);
    add_on_bar("stability bar.toml --load-case case.toml --model fem_p2 --output out");
    for (const auto *arguments :
         {"stability --integrator heun --integrator heun", "stability --damping-ratio nan",
          "stability --damping-frequencies 0 10", "mesh box --size 1 2 --edge 0.1 -o box.msh",
          "mesh box --size 1 0 1 --edge 0.1 -o box.msh", "mesh box --size 1 1 1 --edge nan -o box.msh",
          "mesh cut beam -o cut.msh", "mesh cut beam --half-space 0.05 0 0 1 0 0 --margin 0.005 -o cut.msh",
          "mesh cut beam --half-space 5 0 0 1 0 0 -o cut.msh", "mesh cut beam --half-space 0.05 0 0 1 0 0 -o cut.vtk",
          "mesh liver --tetrahedra 1000000000 -o liver.msh",
          "mesh box --size 1 1 1 --edge 1e-9 --topology kuhn -o box.msh"})
        add(arguments);
    return rows;
}

std::vector<BadInput> bad_places() {
    const std::string box = "mesh box --size 1 1 1 --edge 0.2 --topology kuhn -o ";
    const std::string run_to = "run --body bar.toml --load-case case.toml --model lloyd --reference-on-mesh --output ";
    return {
        without_rights("a mesh that may not be read", "mesh check two.msh", "two.msh"),
        without_rights("a mesh of a body that may not be read", good_run, "bar.msh"),
        without_rights("a body that may not be read", good_run, "bar.toml"),
        without_rights("a load case that may not be read", good_run, "case.toml"),
        without_rights("a result file that may not be read", "table result.h5", "result.h5"),
        without_rights("a solution that may not be read", "score bar.toml case.toml solution.csv --output locked",
                       "solution.csv"),
        without_rights("results into a folder that may not be written to", run_to + "locked", "locked"),
        without_rights("a mesh into a folder that may not be written to", box + "locked/box.msh", "locked"),
        without_rights("a report into a folder that may not be written to", "report runs -o locked/report.html",
                       "locked"),
        place("results below a file", run_to + "a_file"),
        place("a mesh in the place of a directory", box + "folder"),
        place("a mesh into a directory that is not there", box + "nowhere/box.msh"),
        place("a mesh in the place of a device", box + "/dev/full"),
        place("a report in the place of a directory", "report runs -o folder"),
        place("a report into a directory that is not there", "report runs -o nowhere/report.html"),
        full(place("a report on a full disk", "report runs -o folder/report.html")),
        place("a look into a folder that is not there", "view nowhere"),
        place("a look into a file as if it were a folder", "view result.h5"),
        place("a look into a folder without results", "view folder"),
        full(place("a mesh on a full disk", box + "box.msh")),
        full(place("results on a full disk", run_to + "folder")),
        full(place("a problem for others on a full disk", "export bar.toml case.toml -o folder")),
        full(place("modes on a full disk",
                   "modes bar.toml --load-case case.toml --model fem_p1 --count 2 --output folder")),
        to_full_output(place("a table on a full disk", "table result.h5")),
        to_full_output(place("a list on a full disk", "list models")),
    };
}

} // namespace livermark::tests
