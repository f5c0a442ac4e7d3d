#include "results/records/engine_entry.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <fmt/format.h>
#include <sstream>
#include <string_view>
#include <utility>
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

constexpr std::array<EntryField<EngineProblem>, 18> problem_fields{{
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
}};
constexpr EntryField<EngineProblem> message_field{"message", &EngineProblem::message};

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

std::string json_string(const std::string &text) {
    std::ostringstream stream;
    stream << toml::json_formatter(toml::value<std::string>(text));
    return stream.str();
}

std::string json_value(const std::string &text) {
    return json_string(text);
}
std::string json_value(int number) {
    return fmt::format("{}", number);
}
/// JSON has no NaN.
std::string json_value(double number) {
    return std::isfinite(number) ? fmt::format("{}", number) : "null";
}

template <class Record> std::string json_member(const Record &record, const EntryField<Record> &field) {
    return std::visit(
        [&](const auto member) { return fmt::format("\"{}\": {}", field.key, json_value(record.*member)); },
        field.member);
}

/// Text of JSON, read once from front to back. Objects become tables, and members that are null are left out.
class JsonReader {
  public:
    JsonReader(std::string_view text, const std::string &file) : text_(text), file_(file) {}

    toml::table document() {
        skip_space();
        if (peek() != '{')
            refuse("an object has to begin here");
        auto table = object(0);
        skip_space();
        if (at_ != text_.size())
            refuse("there is more behind the end of the object");
        return table;
    }

  private:
    static constexpr int deepest = 32;

    [[noreturn]] void refuse(const char *fault) const {
        const auto line = 1 + std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(at_), '\n');
        throw support::InputError(
            fmt::format("{}:{}: this is not JSON of an entry: {}; correct the line", file_, line, fault));
    }

    char peek() const { return at_ < text_.size() ? text_[at_] : '\0'; }

    void skip_space() {
        while (at_ < text_.size() && std::string_view(" \t\r\n").find(text_[at_]) != std::string_view::npos)
            ++at_;
    }

    bool take(char letter) {
        skip_space();
        if (peek() != letter || at_ == text_.size())
            return false;
        ++at_;
        return true;
    }

    void require(char letter, const char *fault) {
        if (!take(letter))
            refuse(fault);
    }

    bool take_word(std::string_view word) {
        if (text_.substr(at_, word.size()) != word)
            return false;
        at_ += word.size();
        return true;
    }

    /// Hands a value to an action, or calls nothing where it is null.
    template <class Action> void value(int depth, const Action &action) {
        if (depth > deepest)
            refuse("values are in one another too deep");
        skip_space();
        const char first = peek();
        if (first == '{')
            action(object(depth + 1));
        else if (first == '[')
            action(array(depth + 1));
        else if (first == '"')
            action(string());
        else if (take_word("true"))
            action(true);
        else if (take_word("false"))
            action(false);
        else if (!take_word("null"))
            number(action);
    }

    toml::table object(int depth) {
        toml::table table;
        require('{', "an object has to begin here");
        if (take('}'))
            return table;
        do {
            skip_space();
            const auto key = string();
            require(':', "a colon is missing behind a key");
            if (table.contains(key))
                refuse("a key is there twice");
            value(depth, [&](auto found) { table.insert(key, std::move(found)); });
        } while (take(','));
        require('}', "a comma or the end of the object is missing");
        return table;
    }

    toml::array array(int depth) {
        toml::array array;
        require('[', "an array has to begin here");
        if (take(']'))
            return array;
        do
            value(depth, [&](auto found) { array.push_back(std::move(found)); });
        while (take(','));
        require(']', "a comma or the end of the array is missing");
        return array;
    }

    template <class Action> void number(const Action &action) {
        const auto begin = at_;
        while (at_ < text_.size() && std::string_view("+-.0123456789eE").find(text_[at_]) != std::string_view::npos)
            ++at_;
        const auto digits = text_.substr(begin, at_ - begin);
        const auto *const end = digits.data() + digits.size();
        std::int64_t whole = 0;
        if (const auto read = std::from_chars(digits.data(), end, whole); read.ec == std::errc{} && read.ptr == end)
            return action(whole);
        double real = 0.0;
        const auto read = std::from_chars(digits.data(), end, real);
        if (read.ec != std::errc{} || read.ptr != end)
            refuse("a value is missing, or is no number");
        action(real);
    }

    std::string string() {
        require('"', "a text in quotes is missing");
        std::string text;
        while (peek() != '"') {
            if (static_cast<unsigned char>(peek()) < 0x20)
                refuse("the end of a text is missing");
            if (peek() == '\\') {
                ++at_;
                add_escaped(text);
            } else {
                text += text_[at_++];
            }
        }
        ++at_;
        return text;
    }

    void add_escaped(std::string &text) {
        static constexpr std::string_view letters = "\"\\/bfnrt", meanings = "\"\\/\b\f\n\r\t";
        const char letter = peek();
        ++at_;
        if (letter == 'u') {
            add_code_point(text);
            return;
        }
        const auto found = letters.find(letter);
        if (letter == '\0' || found == std::string_view::npos)
            refuse("a backslash stands before a letter that needs none");
        text += meanings[found];
    }

    unsigned four_digits() {
        const auto digits = text_.substr(std::min(at_, text_.size()), 4);
        unsigned code = 0;
        const auto read = std::from_chars(digits.data(), digits.data() + digits.size(), code, 16);
        if (digits.size() != 4 || read.ptr != digits.data() + 4)
            refuse("\\u needs four hexadecimal digits");
        at_ += 4;
        return code;
    }

    /// A character that was written in one or two groups of UTF-16, as UTF-8.
    void add_code_point(std::string &text) {
        unsigned code = four_digits();
        if (code >= 0xd800 && code < 0xe000) {
            if (code >= 0xdc00 || !take_word("\\u"))
                refuse("half of a character is missing");
            const unsigned low = four_digits();
            if (low < 0xdc00 || low >= 0xe000)
                refuse("half of a character is missing");
            code = 0x10000 + ((code - 0xd800) << 10) + (low - 0xdc00);
        }
        const auto add = [&](unsigned byte) { text += static_cast<char>(byte); };
        if (code < 0x80)
            return add(code);
        if (code < 0x800) {
            add(0xc0 | code >> 6);
        } else if (code < 0x10000) {
            add(0xe0 | code >> 12);
            add(0x80 | (code >> 6 & 0x3f));
        } else {
            add(0xf0 | code >> 18);
            add(0x80 | (code >> 12 & 0x3f));
            add(0x80 | (code >> 6 & 0x3f));
        }
        add(0x80 | (code & 0x3f));
    }

    std::string_view text_;
    const std::string &file_;
    std::size_t at_ = 0;
};

[[noreturn]] void refuse_key(const std::string &place, const char *key, const char *fault) {
    throw support::InputError(
        fmt::format("{}: '{}' {}; write the file with `livermark score --entry`", place, key, fault));
}

void take_value(std::string &member, const toml::node &node, const std::string &place, const char *key) {
    if (!node.is_string())
        refuse_key(place, key, "has to be a text");
    member = node.value<std::string>().value();
}
void take_value(int &member, const toml::node &node, const std::string &place, const char *key) {
    const auto number = node.value_exact<std::int64_t>();
    if (!number || *number < 0 || *number > std::numeric_limits<int>::max())
        refuse_key(place, key, "has to be a whole number, and not below 0");
    member = static_cast<int>(*number);
}
void take_value(double &member, const toml::node &node, const std::string &place, const char *key) {
    if (!node.is_number())
        refuse_key(place, key, "has to be a number or null");
    member = node.value<double>().value();
}

template <class Record>
void take_field(Record &record, const toml::table &table, const EntryField<Record> &field, const std::string &place) {
    const auto *node = table.get(field.key);
    if (!node && field.is_required)
        refuse_key(place, field.key, "is missing");
    if (node)
        std::visit([&](const auto member) { take_value(record.*member, *node, place, field.key); }, field.member);
}

template <class Fields>
void refuse_other_keys(const toml::table &table, const Fields &fields, std::initializer_list<std::string_view> more,
                       const std::string &place) {
    for (const auto &entry : table) {
        const auto &key = entry.first;
        const auto is_key = [&](std::string_view known) { return known == key.str(); };
        if (std::ranges::none_of(fields, [&](const auto &field) { return is_key(field.key); }) &&
            std::ranges::none_of(more, is_key))
            refuse_key(place, support::shown(key.str()).c_str(), "is no key of an entry");
    }
}

EngineProblem problem_of(const toml::node &node, const std::string &place) {
    const auto *table = node.as_table();
    if (!table)
        refuse_key(place, "problems", "has to be a list of objects");
    refuse_other_keys(*table, problem_fields, {message_field.key}, place);
    EngineProblem problem;
    for (const auto &field : problem_fields)
        take_field(problem, *table, field, place);
    take_field(problem, *table, message_field, place);
    if (problem.kind != at_rest && problem.kind != in_motion)
        refuse_key(place, "kind", "is neither rest nor motion");
    if (!problem.is_scored() && !problem.has_failed() && problem.outcome != cannot_outcome)
        refuse_key(place, "outcome", "is neither ok, cannot nor failed");
    return problem;
}

} // namespace

std::string engine_entry_text(const EngineEntry &entry) {
    std::string text = "{\n";
    for (const auto &field : entry_fields)
        text += fmt::format("  {},\n", json_member(entry, field));
    std::vector<std::string> sentences;
    for (const auto &sentence : entry.cannot)
        sentences.push_back(json_string(sentence));
    std::ostringstream settings;
    settings << toml::json_formatter(entry.settings,
                                     toml::json_formatter::default_flags & ~toml::format_flags::indentation);
    text += fmt::format("  \"cannot\": [{}],\n  \"settings\": {},\n  \"problems\": [", fmt::join(sentences, ", "),
                        settings.str());
    for (std::size_t i = 0; i < entry.problems.size(); ++i) {
        const auto &problem = entry.problems[i];
        text += i == 0 ? "\n    {\n" : ",\n    {\n";
        for (const auto &field : problem_fields)
            text += fmt::format("      {},\n", json_member(problem, field));
        text += fmt::format("      {}\n    }}", json_member(problem, message_field));
    }
    return text + (entry.problems.empty() ? "]\n}\n" : "\n  ]\n}\n");
}

EngineEntry parse_engine_entry(const std::string &text, const std::string &file) {
    auto table = JsonReader(text, file).document();
    refuse_other_keys(table, entry_fields, {"cannot", "settings", "problems"}, file);
    EngineEntry entry;
    for (const auto &field : entry_fields)
        take_field(entry, table, field, file);
    if (auto *node = table.get("settings")) {
        if (!node->is_table())
            refuse_key(file, "settings", "has to be an object");
        entry.settings = std::move(*node->as_table());
    }
    if (const auto *node = table.get("cannot")) {
        if (!node->is_array())
            refuse_key(file, "cannot", "has to be a list of texts");
        for (const auto &sentence : *node->as_array())
            take_value(entry.cannot.emplace_back(), sentence, file, "cannot");
    }
    const auto *problems = table.get_as<toml::array>("problems");
    if (!problems)
        refuse_key(file, "problems", "is missing, or is no list");
    for (std::size_t i = 0; i < problems->size(); ++i)
        entry.problems.push_back(problem_of(*problems->get(i), fmt::format("{}: problem {}", file, i + 1)));
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
