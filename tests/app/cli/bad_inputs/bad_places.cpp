#include <fstream>

#include "results/hdf5/result_file.hpp"
#include "tests/app/cli/bad_inputs/bad_inputs.hpp"
#include "tests/samples/records/sample_result.hpp"

namespace livermark::tests {

namespace {

namespace fs = std::filesystem;

/// A command on the bar, of which something may not be touched.
BadInput without_rights(std::string name, std::string what, std::string arguments, std::string file, std::string remedy,
                        const std::string &forbidden) {
    return {.name = std::move(name),
            .what = std::move(what),
            .arguments = std::move(arguments),
            .file = std::move(file),
            .place = "Permission denied",
            .remedy = std::move(remedy),
            .files = {{"case.toml", good_case}, {"two.msh", good_msh}, {"solution.csv", "x,y,z,ux,uy,uz\n"}},
            .prepare =
                [=](const fs::path &folder) {
                    write_bar(folder);
                    results::write_result(folder / "result.h5", sample_result());
                    fs::create_directory(folder / "runs");
                    results::write_result(folder / "runs" / "result.h5", sample_result());
                    fs::create_directory(folder / "locked");
                    const auto rights = forbidden == "locked" ? fs::perms::owner_read | fs::perms::owner_exec |
                                                                    fs::perms::others_read | fs::perms::others_exec
                                                              : fs::perms::none;
                    fs::permissions(folder / forbidden, rights);
                },
            .how = {.without_rights = true}};
}

BadInput place(std::string name, std::string what, std::string arguments, std::string file, std::string where,
               std::string remedy) {
    return {.name = std::move(name),
            .what = std::move(what),
            .arguments = std::move(arguments),
            .file = std::move(file),
            .place = std::move(where),
            .remedy = std::move(remedy),
            .files = {{"case.toml", good_case}, {"a_file", "in the way"}},
            .prepare = [](const fs::path &folder) {
                write_bar(folder);
                fs::create_directories(folder / "folder" / "bar");
                results::write_result(folder / "result.h5", sample_result());
                fs::create_directory(folder / "runs");
                results::write_result(folder / "runs" / "result.h5", sample_result());
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

std::vector<BadInput> bad_places() {
    const std::string box = "mesh box --size 1 1 1 --edge 0.2 --topology kuhn -o ";
    const std::string run_to = "run --body bar.toml --load-case case.toml --model lloyd --reference-on-mesh --output ";
    return {
        without_rights("UnreadableMesh", "a mesh that may not be read", "mesh check two.msh",
                       "two.msh:", "its permissions", "two.msh"),
        without_rights("UnreadableMeshOfABody", "a mesh of a body that may not be read", good_run,
                       "bar.msh:", "its permissions", "bar.msh"),
        without_rights("UnreadableBody", "a body that may not be read", good_run, "bar.toml:", "its permissions",
                       "bar.toml"),
        without_rights("UnreadableLoadCase", "a load case that may not be read", good_run,
                       "case.toml:", "its permissions", "case.toml"),
        without_rights("UnreadableResult", "a result file that may not be read", "table result.h5",
                       "result.h5:", "its permissions", "result.h5"),
        without_rights("UnreadableSolution", "a solution that may not be read",
                       "score bar.toml case.toml solution.csv --output locked", "solution.csv:", "its permissions",
                       "solution.csv"),
        without_rights("LockedFolderForResults", "results into a folder that may not be written to", run_to + "locked",
                       "locked/bar:", "choose another --output", "locked"),
        without_rights("LockedFolderForAMesh", "a mesh into a folder that may not be written to",
                       box + "locked/box.msh", "locked/box.msh:", "choose another place", "locked"),
        without_rights("LockedFolderForAReport", "a report into a folder that may not be written to",
                       "report runs -o locked/report.html", "locked/report.html:", "choose another place", "locked"),
        place("FileAsOutput", "results below a file", run_to + "a_file", "a_file/bar:", "", "choose another --output"),
        place("DirectoryForAMesh", "a mesh in the place of a directory", box + "folder",
              "folder:", "this is a directory", "give the name of a file"),
        place("MissingDirectoryForAMesh", "a mesh into a directory that is not there", box + "nowhere/box.msh",
              "nowhere/box.msh:", "there is no directory nowhere", "make it"),
        place("DeviceForAMesh", "a mesh in the place of a device", box + "/dev/full",
              "/dev/full:", "this is not a plain file", "choose another place"),
        place("DirectoryForAReport", "a report in the place of a directory", "report runs -o folder",
              "folder:", "this is a directory", "give the name of a file"),
        place("MissingDirectoryForAReport", "a report into a directory that is not there",
              "report runs -o nowhere/report.html", "nowhere/report.html:", "there is no directory nowhere", "make it"),
        full(place("FullDiskForAReport", "a report on a full disk", "report runs -o folder/report.html",
                   "folder/report.html:", "cannot write", "make room on the disk")),
        place("ViewOfNoFolder", "a look into a folder that is not there", "view nowhere",
              "nowhere:", "there is no such folder", "check the path"),
        place("ViewOfAFile", "a look into a file as if it were a folder", "view result.h5",
              "result.h5:", "this is not a folder", "give the one that the file is in"),
        place("ViewWithoutResults", "a look into a folder without results", "view folder",
              "folder:", "there are no result files", "make some with `livermark run`"),
        full(place("FullDiskForAMesh", "a mesh on a full disk", box + "box.msh", "box.msh:", "cannot write",
                   "make room on the disk")),
        full(place("FullDiskForARun", "results on a full disk", run_to + "folder",
                   "folder/bar/case.h5:", "cannot write", "make room on the disk")),
        full(place("FullDiskForAnExport", "a problem for others on a full disk", "export bar.toml case.toml -o folder",
                   "folder/bar/case.problem.h5:", "cannot write", "make room on the disk")),
        full(place("FullDiskForModes", "modes on a full disk",
                   "modes bar.toml --load-case case.toml --model fem_p1 --count 2 --output folder",
                   "folder/bar/modes.case.h5:", "cannot write", "make room on the disk")),
        to_full_output(place("FullDiskForATable", "a table on a full disk", "table result.h5",
                             "standard output:", "cannot be written", "make room on the disk")),
        to_full_output(place("FullDiskForAList", "a list on a full disk", "list models",
                             "standard output:", "cannot be written", "make room on the disk")),
    };
}

} // namespace livermark::tests
