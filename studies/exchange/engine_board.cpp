#include "studies/exchange/engine_board.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <exception>
#include <fmt/format.h>
#include <initializer_list>
#include <iterator>
#include <sstream>
#include <string_view>
#include <system_error>
#include <utility>

#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/support/processes/child_process.hpp"
#include "core/support/processes/own_process.hpp"
#include "core/support/random_numbers.hpp"
#include "core/support/toml_input.hpp"
#include "meshes/generators/liver_shape.hpp"
#include "results/hdf5/references.hpp"
#include "results/records/result.hpp"
#include "studies/arena/arena.hpp"
#include "studies/cohort/cohort.hpp"
#include "studies/models/model_table.hpp"

namespace livermark::studies {

namespace {

namespace fs = std::filesystem;

/// Load cases of a board, which fit livers of few tetrahedra. Exported files cannot describe a rigid ball, so the large
/// press is that of the motion.
constexpr std::array board_load_cases{"traction", "palpation", "large_traction", "press_and_slide"};
constexpr int board_tetrahedra = 4000;

constexpr int largest_board = 1000000, largest_variant = 1000000, fewest_tetrahedra = 2000, most_tetrahedra = 2000000;

std::string optional_text(const toml::table &table, std::string_view key) {
    return table.contains(key) ? support::required_string(table, key) : "";
}

std::string filled_text(const toml::table &table, std::string_view key) {
    auto text = support::required_string(table, key);
    if (text.empty())
        support::refuse(*table.get(key), "'{}' is empty; fill it in", key);
    return text;
}

int optional_count(const toml::table &table, std::string_view key, int least, int most) {
    const auto *node = table.get(key);
    if (!node)
        return 0;
    const auto number = node->value_exact<std::int64_t>();
    if (!number || *number < least || *number > most)
        support::refuse(*node, "'{}' has to be a whole number from {} to {}; correct it", key, least, most);
    return static_cast<int>(*number);
}

double optional_cost(const toml::table &table, std::string_view key) {
    if (!table.contains(key))
        return results::EngineProblem::unknown;
    const double cost = support::required_number(table, key);
    if (cost < 0.0)
        support::refuse(*table.get(key), "'{}' is {}; it has to be positive", key, cost);
    return cost;
}

/// Refuses a table that has none or both of two keys.
void require_one_of(const toml::table &table, std::string_view first, std::string_view second) {
    if (table.contains(first) == table.contains(second))
        support::refuse(table, "a problem has either '{}' or '{}'; {}", first, second,
                        table.contains(first) ? "leave one out" : "add one");
}

std::string engine_of(const toml::table &table) {
    auto name = filled_text(table, "engine");
    if (const auto fault = fault_of_name(name); !fault.empty())
        support::refuse(*table.get("engine"), "engine '{}': {}", support::shown(name), fault);
    for (const auto &model : models::all_models())
        if (model.name == name)
            support::refuse(*table.get("engine"), "there is a model '{}' already; choose another name", name);
    return name;
}

EntryProblem entry_problem_of(const toml::table &table) {
    support::refuse_unknown_keys(table, {"body", "variant", "tetrahedra", "load_case", "solution", "cannot", "unit",
                                         "seconds_per_frame", "setup_seconds", "memory_bytes"});
    require_one_of(table, "body", "variant");
    require_one_of(table, "solution", "cannot");
    if (table.contains("body") && table.contains("tetrahedra"))
        support::refuse(*table.get("tetrahedra"), "'tetrahedra' belongs to a 'variant'; leave it out");
    EntryProblem problem{.body = table.contains("body") ? filled_text(table, "body") : "",
                         .variant = optional_count(table, "variant", 1, largest_variant),
                         .target_tetrahedra = optional_count(table, "tetrahedra", fewest_tetrahedra, most_tetrahedra),
                         .load_case = filled_text(table, "load_case"),
                         .solution = table.contains("solution") ? filled_text(table, "solution") : "",
                         .unit = optional_text(table, "unit"),
                         .cannot = table.contains("cannot") ? filled_text(table, "cannot") : "",
                         .seconds_per_frame = optional_cost(table, "seconds_per_frame"),
                         .setup_seconds = optional_cost(table, "setup_seconds"),
                         .memory_bytes = optional_cost(table, "memory_bytes")};
    if (!problem.unit.empty())
        support::metres_per_unit(problem.unit, support::place_of(*table.get("unit")));
    return problem;
}

bool is_same_problem(const EntryProblem &one, const EntryProblem &other) {
    return one.body == other.body && one.variant == other.variant && one.target_tetrahedra == other.target_tetrahedra &&
           one.load_case == other.load_case;
}

std::vector<EntryProblem> entry_problems_of(const toml::table &table, int board) {
    const auto *list = table.get_as<toml::array>("problem");
    if (!list || list->empty() || !list->is_array_of_tables())
        support::refuse(table, "there is no [[problem]]; add one for each solution, as in the entry.toml of `livermark "
                               "export --board`");
    const auto livers = board_livers(board);
    std::vector<EntryProblem> problems;
    for (const auto &node : *list) {
        const auto problem = entry_problem_of(*node.as_table());
        if (std::ranges::any_of(problems, [&](const auto &other) { return is_same_problem(problem, other); }))
            support::refuse(node, "this problem is there twice; leave one out");
        if (board > 0 && std::ranges::count(livers, problem.variant) == 0)
            support::refuse(node,
                            "this is no liver of board {}; leave 'board' out, or take the problems of `livermark "
                            "export --board {}`",
                            board, board);
        problems.push_back(problem);
    }
    return problems;
}

/// A path as it is from the folder of an entry file, or a name as it is.
std::string name_or_path(const fs::path &folder, const std::string &text) {
    std::error_code nobody_cares; // reading says it
    const auto path = folder / text;
    return fs::is_regular_file(path, nobody_cares) ? path.string() : text;
}

/// Scores problems one by one, and draws each liver once.
class EntryScorer {
  public:
    EntryScorer(const EntryOptions &options, const EntryFile &file, std::string command_line)
        : options_(options), file_(file), command_line_(std::move(command_line)),
          folder_(fs::absolute(options.entry).parent_path()) {}

    results::EngineProblem score(const EntryProblem &problem, const ProgressReport &report) {
        const auto load_case = name_or_path(folder_, problem.load_case);
        const bool in_motion = moves_tool(load_case);
        results::EngineProblem scored{.body = problem.variant > 0 ? fmt::format("liver_variant_{}", problem.variant)
                                                                  : fs::path(problem.body).stem().string(),
                                      .load_case = fs::path(problem.load_case).stem().string(),
                                      .kind = in_motion ? results::in_motion : results::at_rest,
                                      .variant = problem.variant,
                                      .target_tetrahedra = problem.target_tetrahedra,
                                      .seconds_per_frame = problem.seconds_per_frame,
                                      .setup_seconds = problem.setup_seconds,
                                      .memory_bytes = problem.memory_bytes};
        if (!problem.cannot.empty()) {
            scored.outcome = results::cannot_outcome;
            scored.message = problem.cannot;
            return scored;
        }
        try {
            const ScoreOptions options{.body = body_of(problem),
                                       .load_case = load_case,
                                       .solution = (folder_ / problem.solution).string(),
                                       .name = file_.entry.engine,
                                       .models = options_.models,
                                       .output = scores_folder(),
                                       .reference_on_mesh = options_.reference_on_mesh,
                                       .solve_reference = options_.solve_reference,
                                       .unit = problem.unit};
            if (in_motion)
                take_motion(studies::score_motion(options, command_line_, report), scored);
            else
                take_rest(studies::score(options, command_line_, report), scored);
        } catch (const std::exception &error) {
            scored.outcome = results::failed_outcome;
            scored.message = support::reason_of(error, "take a mesh of fewer tetrahedra");
            // The entry is for others, whom the place of these files does not concern.
            const auto place = folder_.string() + "/";
            for (auto at = scored.message.find(place); at != std::string::npos; at = scored.message.find(place))
                scored.message.erase(at, place.size());
        }
        return scored;
    }

    std::vector<std::string> notes;

  private:
    std::string scores_folder() const {
        return options_.output.empty() ? (support::root_folder() / "results" / "scores").string() : options_.output;
    }

    std::string body_of(const EntryProblem &problem) {
        if (problem.variant == 0)
            return name_or_path(folder_, problem.body);
        const auto folder = drawn_.path / fmt::format("{}", problem.target_tetrahedra);
        fs::create_directories(folder);
        const auto file = cohort_body_file(folder, problem.variant);
        make_cohort_body(file, meshes::draw_liver(problem.variant), problem.target_tetrahedra);
        return file.string();
    }

    /// Takes what a stored problem and a comparison have in common.
    void take_problem(const core::Problem &problem, std::vector<std::string> &&found, results::EngineProblem &scored) {
        scored.body = problem.body->name;
        scored.load_case = problem.load_case.name;
        scored.regime = core::to_string(problem.load_case.regime);
        scored.tetrahedra = static_cast<int>(problem.body->mesh.num_tetrahedra());
        scored.digest = results::fingerprint(problem, "");
        for (auto &note : found)
            if (std::ranges::find(notes, note) == notes.end())
                notes.push_back(std::move(note));
    }

    void take_rest(Score &&score, results::EngineProblem &scored) {
        const auto &result = score.result;
        take_problem(result.problem, std::move(score.notes), scored);
        const auto model = std::ranges::find(result.models, file_.entry.engine, &results::ModelResult::name);
        if (model == result.models.end() || !model->comparison) {
            scored.outcome = results::failed_outcome;
            scored.message = "nothing was compared, because " + reason_without_reference(result);
            return;
        }
        const auto &comparison = *model->comparison;
        scored.relative_l2 = comparison.relative_l2;
        if (comparison.tool)
            scored.stiffness_at_tool = comparison.tool->stiffness();
        scored.reference = comparison.reference;
        if (result.reference_uncertainty)
            scored.reference_error = result.reference_uncertainty->relative_l2;
        if (comparison.load_fraction < 1.0)
            scored.message =
                fmt::format("compared at {:g} of the load, where the reference ends", comparison.load_fraction);
    }

    static std::string reason_without_reference(const results::Result &result) {
        for (const auto &model : result.models)
            if (!model.solution.message.empty())
                return fmt::format("{}: {}", model.name, model.solution.message);
        return "the reference has no solution";
    }

    void take_motion(MotionScore &&score, results::EngineProblem &scored) {
        take_problem(score.problem, std::move(score.notes), scored);
        const auto &run = score.arena.runs.front();
        scored.in_contact = run.errors.contact;
        scored.force = run.errors.force;
        scored.reference = score.arena.reference;
        scored.reference_error = score.arena.reference_errors.contact;
        if (std::isnan(scored.seconds_per_frame))
            scored.seconds_per_frame = run.frame_seconds;
    }

    const EntryOptions &options_;
    const EntryFile &file_;
    std::string command_line_;
    fs::path folder_;
    support::ScratchFolder drawn_;
};

std::string entry_template(int seed) {
    auto text = fmt::format("# An entry for the problems of `livermark export --board {0}`. Solve each one, put its "
                            "solution where 'solution'\n"
                            "# says, fill in this file, and run `livermark score --entry` with it.\n"
                            "engine = \"mine\"     # letters, digits, _ and - only\n"
                            "version = \"unknown\"\n"
                            "url = \"\"            # where others get it\n"
                            "machine = \"unknown\" # processor, graphics card, threads\n"
                            "notes = \"\"\n"
                            "cannot = []         # what it cannot do, a sentence each\n"
                            "board = {0}\n\n"
                            "[settings] # what somebody has to know who does the same again, such as substeps = 20\n\n"
                            "# Each problem may also have setup_seconds, seconds_per_frame and memory_bytes. Where the "
                            "engine has no solution,\n"
                            "# write cannot = \"why\" in place of 'solution'.\n",
                            seed);
    for (const int liver : board_livers(seed))
        for (const std::string load_case : board_load_cases)
            text +=
                fmt::format("\n[[problem]]\nvariant = {0}\ntetrahedra = {1}\nload_case = \"{2}\"\n"
                            "solution = \"liver_variant_{0}/{2}.{3}\"\n",
                            liver, board_tetrahedra, load_case, moves_tool(load_case) ? "motion.h5" : "solution.csv");
    return text;
}

nlohmann::ordered_json json_of(const toml::table &table) {
    std::ostringstream text;
    text << toml::json_formatter(table);
    return nlohmann::ordered_json::parse(text.str());
}

} // namespace

EntryFile parse_entry_file(const std::string &text, const std::filesystem::path &file) {
    const auto table = support::parse_toml(text, file);
    support::refuse_unknown_keys(
        table, {"engine", "version", "url", "machine", "notes", "cannot", "board", "settings", "problem"});
    EntryFile parsed{.entry = {.engine = engine_of(table),
                               .version = filled_text(table, "version"),
                               .url = optional_text(table, "url"),
                               .machine = filled_text(table, "machine"),
                               .notes = optional_text(table, "notes"),
                               .board = optional_count(table, "board", 1, largest_board)},
                     .problems = {}};
    if (const auto *sentences = table.get_as<toml::array>("cannot"); !sentences || !sentences->empty())
        if (table.contains("cannot"))
            parsed.entry.cannot = support::required_strings(table, "cannot");
    if (table.contains("settings"))
        parsed.entry.settings = json_of(support::required_table(table, "settings"));
    parsed.problems = entry_problems_of(table, parsed.entry.board);
    return parsed;
}

ScoredEntry score_entry(const EntryOptions &options, const std::string &command_line, const ProgressReport &report) {
    const auto file = parse_entry_file(support::read_text(options.entry), options.entry);
    const auto folder = options.output.empty() ? fs::absolute(options.entry).parent_path() : fs::path(options.output);
    const OutputFile output(folder, file.entry.engine + ".json");
    const auto provenance = results::current_provenance(command_line);
    ScoredEntry scored{.entry = file.entry, .file = output.path(), .notes = {}};
    scored.entry.livermark = provenance.software_version;
    scored.entry.git_commit = provenance.git_commit;
    scored.entry.created = provenance.created;
    EntryScorer scorer(options, file, command_line);
    for (const auto &problem : file.problems) {
        const auto step = static_cast<int>(scored.entry.problems.size()) + 1;
        const auto report_on_problem = [&](int, int, const std::string &about) {
            if (report)
                report(step, static_cast<int>(file.problems.size()), about);
        };
        scored.entry.problems.push_back(scorer.score(problem, report_on_problem));
    }
    scored.notes = std::move(scorer.notes);
    results::write_engine_entry(scored.file, scored.entry);
    return scored;
}

std::vector<int> board_livers(int seed) {
    constexpr int first_pair = 501;
    support::RandomNumbers random(static_cast<std::uint64_t>(seed));
    const auto draw = [&] { return 2 * (first_pair + random.below(largest_variant / 2 - first_pair)); };
    std::vector<int> livers{draw(), draw()};
    while (livers[1] == livers[0])
        livers[1] = draw();
    return livers;
}

ExportedProblem export_board(int seed, const ExportOptions &options, const std::string &command_line,
                             const ProgressReport &report) {
    const OutputFolder folder(options.output);
    const OutputFile entry(folder.path(), "entry.toml");
    if (fs::exists(entry.path()))
        throw support::InputError("{}: there is an entry already; remove it, or choose another --output",
                                  entry.path().string());
    const OutputFolder bodies(folder.path() / "bodies");
    const auto livers = board_livers(seed);
    ExportedProblem exported;
    Steps steps(static_cast<int>(livers.size() * board_load_cases.size()), report);
    for (const int number : livers) {
        const auto body = cohort_body_file(bodies.path(), number);
        check_cohort_body(body, number, board_tetrahedra);
        make_cohort_body(body, meshes::draw_liver(number), board_tetrahedra);
        exported.files.push_back(body);
        for (const std::string load_case : board_load_cases) {
            steps.next(fmt::format("{} / {}", body.stem().string(), load_case));
            auto problem = options;
            problem.body = body.string();
            problem.load_case = load_case;
            auto [files, notes] = export_problem(problem, command_line);
            std::ranges::move(files, std::back_inserter(exported.files));
            std::ranges::move(notes, std::back_inserter(exported.notes));
        }
    }
    support::write_whole(entry.path(), entry_template(seed));
    exported.files.push_back(entry.path());
    return exported;
}

} // namespace livermark::studies
