#include "results/records/engine_entry.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <functional>
#include <limits>
#include <set>
#include <string_view>
#include <variant>

#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/units.hpp"
#include "results/tables/table_layout.hpp"

namespace livermark::results {

namespace {

/// A number or text of a file: its key, and the member that has it.
template <class Record> struct EntryField {
    const char *key;
    std::variant<std::string Record::*, int Record::*, double Record::*> member;
    bool is_required = false;
};

constexpr std::array<EntryField<EngineProblem>, 19> problem_fields{{
    {"body", &EngineProblem::body, true},
    {"load_case", &EngineProblem::load_case, true},
    {"kind", &EngineProblem::kind, true},
    {"regime", &EngineProblem::regime},
    {"variant", &EngineProblem::variant},
    {"target_tetrahedra", &EngineProblem::target_tetrahedra},
    {"tetrahedra", &EngineProblem::tetrahedra},
    {"digest", &EngineProblem::digest},
    {"relative_l2", &EngineProblem::relative_l2},
    {"stiffness_at_tool", &EngineProblem::stiffness_at_tool},
    {"in_contact", &EngineProblem::in_contact},
    {"force", &EngineProblem::force},
    {"reference", &EngineProblem::reference},
    {"reference_error", &EngineProblem::reference_error},
    {"seconds_per_frame", &EngineProblem::seconds_per_frame},
    {"setup_seconds", &EngineProblem::setup_seconds},
    {"memory_bytes", &EngineProblem::memory_bytes},
    {"outcome", &EngineProblem::outcome, true},
    {"message", &EngineProblem::message},
}};

constexpr std::array<EntryField<EngineEntry>, 9> entry_fields{{
    {"engine", &EngineEntry::engine, true},
    {"version", &EngineEntry::version, true},
    {"url", &EngineEntry::url},
    {"machine", &EngineEntry::machine},
    {"notes", &EngineEntry::notes},
    {"board", &EngineEntry::board},
    {"livermark", &EngineEntry::livermark},
    {"git_commit", &EngineEntry::git_commit},
    {"created", &EngineEntry::created},
}};

using Json = nlohmann::ordered_json;

/// Members of a record; numbers that are not known become null.
template <class Record, class Fields> Json json_of(const Record &record, const Fields &fields) {
    Json object = Json::object();
    for (const auto &field : fields)
        std::visit([&](const auto member) { object[field.key] = record.*member; }, field.member);
    return object;
}

/// Refusal of what the library takes in silence: keys that are there twice, and values too deep in one another.
class StrictParsing {
  public:
    explicit StrictParsing(const std::string &file) : file_(file) {}

    bool operator()(int depth, Json::parse_event_t event, const Json &value) {
        if (depth > deepest)
            refuse("values are in one another too deep");
        if (event == Json::parse_event_t::object_start)
            keys_of_open_.emplace_back();
        else if (event == Json::parse_event_t::object_end)
            keys_of_open_.pop_back();
        else if (event == Json::parse_event_t::key && !keys_of_open_.back().insert(value.get<std::string>()).second)
            refuse(fmt::format("the key {} is there twice", support::shown(value.get<std::string>())));
        return true;
    }

    [[noreturn]] void refuse(const std::string &fault) const {
        throw support::InputError(fmt::format("{}: this is not JSON of an entry: {}; correct it", file_, fault));
    }

  private:
    static constexpr int deepest = 32;

    const std::string &file_;
    std::vector<std::set<std::string>> keys_of_open_; ///< of the objects that have begun
};

Json parse_json(const std::string &text, const std::string &file) {
    StrictParsing strict(file);
    try {
        auto document = Json::parse(text, std::ref(strict));
        if (!document.is_object())
            strict.refuse("it is no object");
        return document;
    } catch (const Json::exception &error) {
        const std::string fault = error.what();
        strict.refuse(fault.substr(std::min(fault.size(), fault.find("] ") + 2))); // behind the library's own number
    }
}

[[noreturn]] void refuse_key(const std::string &place, const char *key, const char *fault) {
    throw support::InputError(
        fmt::format("{}: '{}' {}; write the file with `livermark score --entry`", place, key, fault));
}

void take_value(std::string &member, const Json &value, const std::string &place, const char *key) {
    if (!value.is_string())
        refuse_key(place, key, "has to be a text");
    member = value.get<std::string>();
}
void take_value(int &member, const Json &value, const std::string &place, const char *key) {
    if (!value.is_number_integer() || value < 0 || value > std::numeric_limits<int>::max())
        refuse_key(place, key, "has to be a whole number, and not below 0");
    member = value.get<int>();
}
void take_value(double &member, const Json &value, const std::string &place, const char *key) {
    if (!value.is_number())
        refuse_key(place, key, "has to be a number or null");
    member = value.get<double>();
}

/// The value of a key, or nothing where it is missing or null.
const Json *value_of(const Json &object, const char *key) {
    const auto found = object.find(key);
    return found == object.end() || found->is_null() ? nullptr : &*found;
}

template <class Record>
void take_field(Record &record, const Json &object, const EntryField<Record> &field, const std::string &place) {
    const auto *value = value_of(object, field.key);
    if (!value && field.is_required)
        refuse_key(place, field.key, "is missing");
    if (value)
        std::visit([&](const auto member) { take_value(record.*member, *value, place, field.key); }, field.member);
}

template <class Fields>
void refuse_other_keys(const Json &object, const Fields &fields, std::initializer_list<std::string_view> more,
                       const std::string &place) {
    for (const auto &entry : object.items()) {
        const auto &key = entry.key();
        if (std::ranges::none_of(fields, [&](const auto &field) { return key == field.key; }) &&
            std::ranges::find(more, key) == more.end())
            refuse_key(place, support::shown(key).c_str(), "is no key of an entry");
    }
}

EngineProblem problem_of(const Json &object, const std::string &place) {
    if (!object.is_object())
        refuse_key(place, "problems", "has to be a list of objects");
    refuse_other_keys(object, problem_fields, {}, place);
    EngineProblem problem;
    for (const auto &field : problem_fields)
        take_field(problem, object, field, place);
    if (problem.kind != at_rest && problem.kind != in_motion)
        refuse_key(place, "kind", "is neither rest nor motion");
    if (!problem.is_scored() && !problem.has_failed() && problem.outcome != cannot_outcome)
        refuse_key(place, "outcome", "is neither ok, cannot nor failed");
    return problem;
}

} // namespace

std::string engine_entry_text(const EngineEntry &entry) {
    auto object = json_of(entry, entry_fields);
    object["cannot"] = entry.cannot;
    object["settings"] = entry.settings;
    auto &problems = object["problems"] = Json::array();
    for (const auto &problem : entry.problems)
        problems.push_back(json_of(problem, problem_fields));
    return object.dump(2) + '\n';
}

EngineEntry parse_engine_entry(const std::string &text, const std::string &file) {
    const auto object = parse_json(text, file);
    refuse_other_keys(object, entry_fields, {"cannot", "settings", "problems"}, file);
    EngineEntry entry;
    for (const auto &field : entry_fields)
        take_field(entry, object, field, file);
    if (const auto *settings = value_of(object, "settings")) {
        if (!settings->is_object())
            refuse_key(file, "settings", "has to be an object");
        entry.settings = *settings;
    }
    if (const auto *cannot = value_of(object, "cannot")) {
        if (!cannot->is_array())
            refuse_key(file, "cannot", "has to be a list of texts");
        for (const auto &sentence : *cannot)
            take_value(entry.cannot.emplace_back(), sentence, file, "cannot");
    }
    const auto *problems = value_of(object, "problems");
    if (!problems || !problems->is_array())
        refuse_key(file, "problems", "is missing, or is no list");
    for (std::size_t i = 0; i < problems->size(); ++i)
        entry.problems.push_back(problem_of((*problems)[i], fmt::format("{}: problem {}", file, i + 1)));
    return entry;
}

void write_engine_entry(const std::filesystem::path &path, const EngineEntry &entry) {
    support::write_whole(path, engine_entry_text(entry));
}

EngineEntry read_engine_entry(const std::filesystem::path &path) {
    return parse_engine_entry(support::read_text(path), path.string());
}

Layout engine_entry_table(const EngineEntry &entry) {
    using Problem = EngineProblem;
    TableOf<Problem> table(entry.problems);
    table.text("body", &Problem::body);
    table.text("load case", &Problem::load_case);
    table.number("tetrahedra",
                 [](const Problem &row) { return row.tetrahedra > 0 ? std::to_string(row.tetrahedra) : "-"; });
    table.text("outcome", &Problem::outcome);
    table.number("L2 [%]", &Problem::relative_l2, core::percent, 2);
    table.signed_number("tool [%]", &Problem::stiffness_at_tool, core::percent, 1);
    table.number("in contact [%]", &Problem::in_contact, core::percent, 1);
    table.number("force [%]", &Problem::force, core::percent, 1);
    table.number("+- [%]", &Problem::reference_error, core::percent, 2);
    table.text("reference", [](const Problem &row) { return row.reference.empty() ? "-" : row.reference; });
    table.number("frame [ms]", &Problem::seconds_per_frame, core::milliseconds, 2);
    table.number("set-up [s]", &Problem::setup_seconds, 1.0, 2);
    table.number("memory [MB]", &Problem::memory_bytes, 1e-6, 0);
    return table.layout();
}

std::string engine_entry_legend() {
    return "L2: error of the displacement of the whole body at rest; tool: of the stiffness at the tool, positive is "
           "too stiff; in contact and force: of displacements and of the force on the tool in motion; +-: estimated "
           "error of the reference in L2, or in contact; frame, set-up and memory: as the maker says\n";
}

} // namespace livermark::results
