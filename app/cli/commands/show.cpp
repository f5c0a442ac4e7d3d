#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>
#include <unistd.h>
#include <utility>
#include <vector>

#include "app/cli/body_sources.hpp"
#include "app/cli/commands.hpp"
#include "app/server/sessions/live_fem.hpp"
#include "app/server/sessions/live_springs.hpp"
#include "app/server/site.hpp"
#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/support/processes/child_process.hpp"
#include "core/tool/tool_stiffness.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "meshes/io/body_reader.hpp"
#include "msm/integrator.hpp"
#include "msm/spring_law.hpp"
#include "results/hdf5/result_file.hpp"
#include "studies/models/model_table.hpp"
#include "studies/models/motion/moving_method.hpp"
#include "studies/report/report_data.hpp"
#include "studies/study.hpp"

namespace livermark::cli {

namespace {

void print_entry(const std::string &name, const std::string &text) {
    fmt::print("{:<24} {}\n", name, text);
}

void list_bodies() {
    for (const auto &file : studies::find_toml_files({}, studies::bodies_folder, "body"))
        print_entry(file.stem().string(), meshes::body_title(file));
}

void list_load_cases_in(const char *folder) {
    for (const auto &file : studies::find_toml_files({}, folder, "load case"))
        print_entry(file.stem().string(), load_cases::load_case_title(file));
}

void list_models() {
    for (const auto &model : models::all_models())
        print_entry(model.name, fmt::format("{} [{}]", model.summary, model.source));
}

void list_spring_laws() {
    for (const auto &law : msm::all_spring_laws())
        print_entry(law.name, fmt::format("{} [{}]", law.summary, law.source));
}

void list_methods() {
    for (const auto &method : models::all_moving_methods())
        print_entry(method.name, fmt::format("{} [{}]", method.implementation, method.source));
}

void list_integrators() {
    for (const auto &integrator : msm::known_integrators())
        print_entry(integrator.name, fmt::format("{} [{}]", integrator.summary, integrator.source));
}

struct List {
    std::string name;
    void (*print)();
};

const std::vector<List> &lists() {
    static const std::vector<List> table{
        {"bodies", list_bodies},
        {"load-cases", [] { list_load_cases_in(studies::load_cases_folder); }},
        {"moving-load-cases", [] { list_load_cases_in(studies::moving_load_cases_folder); }},
        {"touching-load-cases", [] { list_load_cases_in(studies::touching_load_cases_folder); }},
        {"needle-load-cases", [] { list_load_cases_in(studies::needle_load_cases_folder); }},
        {"slow-load-cases", [] { list_load_cases_in(studies::slow_load_cases_folder); }},
        {"models", list_models},
        {"methods", list_methods},
        {"spring-laws", list_spring_laws},
        {"integrators", list_integrators}};
    return table;
}

struct TableOptions {
    std::vector<std::string> paths;
    TableKind kind = TableKind::all;
    bool markdown = false;
};

int print(const TableOptions &options) {
    const std::vector<std::filesystem::path> paths(options.paths.begin(), options.paths.end());
    const auto results = results::read_results(paths);
    print_tables(results, options.kind, options.markdown);
    return 0;
}

struct ReportOptions {
    std::string folder;
    std::string output;
    bool has_figures = false; ///< as files too
};

/// A text in JSON; bytes that are no UTF-8 become U+FFFD.
std::string json_text(const std::string &text) {
    return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

/// A place below the tool of a load case, for slices of the image of its body.
struct PlaceBelow {
    std::string load_case;
    double radius = 0.0;      ///< of the tool [m]
    core::Vector3 at;         ///< [m]
    std::filesystem::path by; ///< the result file
};

/// The place below the first tool of a load case, a little inside the body, where planes along its surface cut it.
std::optional<PlaceBelow> place_below(const results::Result &result, const std::filesystem::path &file) {
    constexpr double deepest = 0.01; // [m]
    const auto &mesh = result.problem.body->mesh;
    const auto tools = core::tool_places(mesh, result.problem.load_case);
    if (tools.empty())
        return std::nullopt;
    const auto &tool = tools.front();
    core::Vector3 outward = core::Vector3::Zero();
    for (const int facet : tool.facets)
        outward += core::area_vector(mesh, facet);
    const double length = outward.norm();
    const core::Vector3 inward = length > 0.0 ? core::Vector3(-outward / length) : core::Vector3::Zero();
    return PlaceBelow{result.problem.load_case.name, tool.radius, tool.middle + std::min(tool.radius, deepest) * inward,
                      file};
}

/// Slices of the images of bodies, below the smallest tool on each, as JSON: by body, with the load case.
std::string slices_of(const studies::ReportData &data) {
    std::map<std::string, PlaceBelow> by_body;
    const auto look = [&](const std::vector<results::Result> &all, const std::vector<std::string> &files) {
        for (std::size_t r = 0; r < all.size(); ++r) {
            const auto &body = all[r].problem.body->name;
            const auto place = place_below(all[r], data.folder / files[r]);
            if (const auto known = by_body.find(body);
                place && (known == by_body.end() || place->radius < known->second.radius))
                by_body.insert_or_assign(body, *place);
        }
    };
    look(data.results, data.files.results);
    look(data.large, data.files.large);
    std::vector<std::string> entries;
    for (const auto &[body, place] : by_body) {
        std::string slices;
        for (const auto &file : body_files_of(place.by, body, data.folder))
            if (slices.empty())
                slices = slices_of_image(file, place.at);
        if (!slices.empty())
            entries.push_back(fmt::format("{}: {{\"load_case\": {}, \"slices\": {}}}", json_text(body),
                                          json_text(place.load_case), slices));
    }
    return entries.empty() ? "" : fmt::format("{{{}}}", fmt::join(entries, ", "));
}

/// @param figures  folder for the figures as files; empty for none
/// @param slices   as slices_of(); empty for none
std::string page_of(const studies::ReportData &data, const std::string &command_line,
                    const std::filesystem::path &figures, const std::string &slices) {
    std::vector<std::string> arguments;
    if (!figures.empty())
        arguments = {"--figures", std::filesystem::absolute(figures).string()};
    const support::ScratchFolder scratch;
    if (!slices.empty()) {
        arguments.insert(arguments.end(), {"--slices", (scratch.path / "slices.json").string()});
        support::write_whole(arguments.back(), slices);
    }
    return support::run_python("report", arguments, studies::report_tables(data, command_line), "a report",
                               "python3-matplotlib python3-jinja2 python3-h5py");
}

/// A file that Python refuses where this program does not, with the sentence: what livermark.report prints in place of
/// a page.
std::optional<std::pair<std::string, std::string>> refused_by_python(const std::string &page) {
    std::istringstream lines(page);
    std::string first, file, sentence;
    if (!std::getline(lines, first) || first != "left out")
        return std::nullopt;
    std::getline(lines, file);
    std::getline(lines, sentence);
    return std::pair(file, sentence);
}

/// Takes the names of the figures that were written from the start of what livermark.report prints: a line "figures", a
/// name in each line, and an empty line before the page.
std::vector<std::string> take_figures(std::string &page) {
    constexpr std::string_view start = "figures\n";
    std::vector<std::string> names;
    if (!page.starts_with(start))
        return names;
    auto place = start.size();
    for (auto end = page.find('\n', place); end != std::string::npos && end != place; end = page.find('\n', place)) {
        names.push_back(page.substr(place, end - place));
        place = end + 1;
    }
    page.erase(0, std::min(place + 1, page.size()));
    return names;
}

int make_report(const ReportOptions &options, const std::string &command_line) {
    const std::filesystem::path folder = options.folder;
    const std::filesystem::path output =
        options.output.empty() ? folder / "report.html" : std::filesystem::path(options.output);
    const auto figures = options.has_figures ? output.parent_path() / "figures" : std::filesystem::path();
    auto data = studies::read_report_data(folder);
    support::check_place(output);
    std::map<std::string, std::string> left_out;
    const auto slices = slices_of(data);
    auto page = page_of(data, command_line, figures, slices);
    while (const auto refused = refused_by_python(page)) {
        if (!left_out.insert(*refused).second)
            throw support::InputError(refused->second);
        data = studies::read_report_data(folder, left_out);
        page = page_of(data, command_line, figures, slices);
    }
    const auto names = take_figures(page);
    support::write_whole(output, page);
    fmt::print("{}\n", output.string());
    for (const auto &name : names)
        fmt::print("{0}.svg\n{0}.pdf\n", (figures / name).string());
    for (const auto &fault : data.faults)
        fmt::print(stderr, "livermark: left out: {}\n", fault);
    return data.faults.empty() ? 0 : 1;
}

namespace fs = std::filesystem;

/// Whether somebody sits in front of this: standard output is a terminal, and there is a screen.
bool has_screen() {
    const auto is_set = [](const char *name) {
        const char *value = std::getenv(name); // NOLINT(concurrency-mt-unsafe): nobody changes the environment
        return value && *value;
    };
    return isatty(fileno(stdout)) != 0 && (is_set("DISPLAY") || is_set("WAYLAND_DISPLAY"));
}

/// Shows an address in the browser of the desktop (`xdg-open`), which goes on when this program ends.
///
/// Every user of the machine may read the words that a program is started with, and the address has the token: what
/// `xdg-open` is given is a file for this user alone, which leads there.
class OpenedBrowser {
  public:
    /// @param address  http://...
    /// @throws support::InputError if no temporary file can be made
    explicit OpenedBrowser(const std::string &address) {
        const auto file = folder_.path / "open.html";
        std::ofstream(file) << fmt::format("<!doctype html><meta charset=\"utf-8\"><title>Livermark</title>\n"
                                           "<meta http-equiv=\"refresh\" content=\"0; url={0}\">\n"
                                           "<p><a href=\"{0}\">The page of livermark view</a></p>\n",
                                           address);
        // A session of its own: Ctrl-C in this terminal ends the server, and not the browser.
        constexpr auto *start = "command -v xdg-open >/dev/null || exit 1\n"
                                "setsid xdg-open \"$1\" </dev/null >/dev/null 2>&1 &";
        was_started_ = support::run_program({"sh", "-c", start, "sh", file.string()}).status == 0;
    }

    /// False where there is no `xdg-open`.
    bool was_started() const { return was_started_; }

  private:
    support::ScratchFolder folder_; ///< with the file; it goes with this object
    bool was_started_ = false;
};

struct ViewOptions {
    std::string folder;
    std::uint16_t port = 8421;
    std::optional<bool> opens_browser; ///< nothing said: where there is a screen
};

/// Without symlinks and dots, so that paths below it can be told.
fs::path existing_folder(const std::string &name) {
    std::error_code error;
    auto folder = fs::canonical(name, error);
    if (error)
        throw support::InputError(
            fmt::format("{}: there is no such folder; check the path, or make results with `livermark run`", name));
    if (!fs::is_directory(folder, error))
        throw support::InputError(fmt::format("{}: this is not a folder; give the one that the file is in", name));
    return folder;
}

fs::path built_page() {
    auto page = support::root_folder() / "app" / "viewer" / "dist" / "index.html";
    std::error_code error;
    if (!fs::is_regular_file(page, error))
        throw support::InputError(
            fmt::format("{}: the page is not there; make it with: cd {} && npm ci && npm run build", page.string(),
                        (support::root_folder() / "app" / "viewer").string()));
    return page;
}

int view(const ViewOptions &options) {
    const auto folder = existing_folder(options.folder);
    server::Site site{
        .folder = folder,
        .page = {},
        .port = options.port,
        .token = server::new_token(),
        .is_result_file = server::remembered(results::is_shown_on_page),
        .image_of =
            [folder](const fs::path &file) {
                return voxels_of_image(body_files_of(file, results::body_in(file), folder));
            },
        .sessions = {
            {"/live/fem",
             [folder](const server::Fields &query, const server::ReportProgress &report) {
                 return server::live_fem(folder, query, report);
             }},
            {"/live/springs", [folder](const server::Fields &query,
                                       const server::ReportProgress &) { return server::live_springs(folder, query); }},
        }};
    const auto files = server::result_files(site);
    const auto num_files = files.paths.size();
    if (files.num_not_utf8 > 0)
        fmt::print(stderr,
                   "livermark: {}: the names of {} more result files are not UTF-8, and they are left out; "
                   "rename them\n",
                   support::shown(options.folder), files.num_not_utf8);
    if (files.num_in_use > 0 && num_files > 0)
        fmt::print(stderr,
                   "livermark: {}: another program has {} of the files open to write, and they are left out until it "
                   "closes them\n",
                   support::shown(options.folder), files.num_in_use);
    if (num_files == 0 && files.num_in_use > 0)
        throw support::InputError(fmt::format(
            "{}: another program has all result files here open to write; close them there", options.folder));
    if (num_files == 0)
        throw support::InputError(
            fmt::format("{}: there are no result files here; make some with `livermark run`", options.folder));
    site.page = built_page();
    std::optional<OpenedBrowser> browser;
    server::serve(site, [&](std::uint16_t port) {
        const auto address = fmt::format("http://127.0.0.1:{}/?token={}", port, site.token);
        fmt::print("{}: {} result file{}, to be seen at {} until Ctrl-C\n", options.folder, num_files,
                   num_files == 1 ? "" : "s", address);
        std::fflush(stdout);
        if (!options.opens_browser.value_or(has_screen()))
            return;
        browser.emplace(address);
        if (!browser->was_started())
            fmt::print(stderr, "livermark: there is no xdg-open to open a browser with (Debian package xdg-utils); "
                               "open the address yourself\n");
    });
    return 0;
}

} // namespace

Command add_list(CLI::App &parent) {
    auto *command = parent.add_subcommand(
        "list", "List bodies, load cases (also those with a moving or touching tool, with a needle, or of tissue that "
                "relaxes), models, methods of the arena, spring laws or integrators");
    auto what = std::make_shared<std::string>();
    const auto names = support::names_of(lists());
    command->add_option("what", *what, fmt::format("One of {}", fmt::join(names, ", ")))
        ->required()
        ->check(one_of(names));
    return [what] {
        support::find_named(lists(), CLI::detail::to_lower(*what), "list").print();
        return 0;
    };
}

Command add_table(CLI::App &parent) {
    auto *command = parent.add_subcommand("table", "Print tables of existing result files");
    auto options = std::make_shared<TableOptions>();
    options->paths = {runs_folder()};
    command->add_option("paths", options->paths, "Result files of 'livermark run', or folders of them")
        ->capture_default_str();
    command
        ->add_option(
            "--kind", options->kind,
            "all, brief (two numbers for each model and body, as at the end of a run), models (a row for each model "
            "and load case), forces (of large deformations along the path of the load), summary (a column for each "
            "load case), overview (columns for each Poisson's ratio), means (columns for each body), medians (over "
            "load cases, for each Poisson's ratio, with load cases of pressure separately), or cohort (over bodies "
            "whose names end in a number, odd and even numbers separately)")
        ->transform(one_of(table_kinds))
        ->default_str("all");
    command->add_flag("--markdown", options->markdown, "Print the tables in Markdown");
    return [options] { return print(*options); };
}

Command add_report(CLI::App &parent, const std::string &command_line) {
    auto *command = parent.add_subcommand(
        "report",
        "Write tables, plots and pictures of the result files in a folder into one HTML file, and print its path");
    auto options = std::make_shared<ReportOptions>();
    options->folder = runs_folder();
    command
        ->add_option("folder", options->folder,
                     "Folder with files of 'livermark run', 'stability' and step_benchmark --hdf5")
        ->capture_default_str();
    command->add_option("-o,--output", options->output, "The HTML file; by default <folder>/report.html");
    command->add_flag(
        "--figures", options->has_figures,
        "Write each figure as .svg and .pdf too, into a folder figures beside the HTML file, and print their "
        "paths");
    return [options, command_line] { return make_report(*options, command_line); };
}

Command add_view(CLI::App &parent) {
    auto *command = parent.add_subcommand("view", "Show result files in a browser on this machine");
    auto options = std::make_shared<ViewOptions>();
    options->folder = runs_folder();
    command
        ->add_option("folder", options->folder,
                     "Folder with files of 'livermark run' or 'livermark experiment', at any depth")
        ->capture_default_str();
    command->add_option("--port", options->port, "Port on 127.0.0.1; 0 takes a free one")
        ->check(CLI::Range(0, 65535))
        ->capture_default_str();
    command->add_flag("--browser,!--no-browser", options->opens_browser,
                      "Open the page in a browser, or not; by default it opens if there is a screen");
    return [options] { return view(*options); };
}

} // namespace livermark::cli
