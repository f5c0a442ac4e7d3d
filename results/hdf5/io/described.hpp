#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <fmt/format.h>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/load_case.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "core/solution.hpp"
#include "core/support/input_error.hpp"
#include "results/hdf5/io/hdf5_io.hpp"
#include "results/records/arena.hpp"

/// A record is described once, and the description writes it, reads it and makes the columns of its tables. It is a
/// template over the place, GroupWriter and GroupReader in a file or Cells of tables (columns.hpp), which have the same
/// functions: the name in the file first, then what stands there.
///
///     template <class At> void describe_cut(At at, Of<At, CutFile> &cut) {
///         at.number("toughness", cut.toughness);
///         at.rows("depth", cut.depth, "m");
///         at.rows("area", cut.area, "m^2", cut.depth.size());
///     }
///
/// A number or a text is an attribute of the place, rows are a dataset below it, of the given units.
/// Sizes and ranges that a description names are checked where a file is read; what is written has them. Reading throws
/// a support::InputError that names the file and the place. Internal to results/.
namespace livermark::results::hdf5 {

/// Enumerations whose values files hold as words: `all` is the array of the values, to_string() says the word of each.
template <class Value> struct Words;

template <> struct Words<core::Regime> { static constexpr std::array all{core::Regime::small, core::Regime::large}; };

template <> struct Words<core::ToolFace> {
    static constexpr std::array all{core::ToolFace::ball, core::ToolFace::round, core::ToolFace::square};
};

template <> struct Words<core::SolutionStatus> {
    static constexpr std::array all{core::SolutionStatus::ok, core::SolutionStatus::diverged,
                                    core::SolutionStatus::not_converged};
};

template <> struct Words<ArenaOutcome> {
    static constexpr std::array all{ArenaOutcome::ok, ArenaOutcome::too_slow, ArenaOutcome::diverged};
};

/// The value that a word stands for; nothing if it stands for none.
template <class Value> std::optional<Value> value_of_word(const std::string &word) {
    const auto found =
        std::ranges::find_if(Words<Value>::all, [&](const Value value) { return word == to_string(value); });
    return found == Words<Value>::all.end() ? std::nullopt : std::optional(*found);
}

/// Words in the order of the enumeration.
template <class Value> std::vector<std::string> all_words() {
    std::vector<std::string> words;
    for (const Value value : Words<Value>::all)
        words.emplace_back(to_string(value));
    return words;
}

/// Every index of every row in [first, end).
inline void check_indices(const InputFile &file, const std::string &path, std::span<const int> indices, int columns,
                          int first, std::size_t end) {
    const auto bad = std::ranges::find_if(
        indices, [&](int index) { return index < first || index >= static_cast<std::int64_t>(end); });
    if (bad != indices.end())
        file.refuse(path, fmt::format("row {} holds {}, which is not in [{}, {})", (bad - indices.begin()) / columns,
                                      *bad, first, end));
}

/// One index of each row, checked.
inline std::vector<int> indices(const InputFile &file, const std::string &path, std::size_t num_rows, int first,
                                std::size_t end) {
    auto values = file.dataset<int>(path, num_rows);
    check_indices(file, path, values, 1, first, end);
    return values;
}

inline void check_finite(const InputFile &file, const std::string &path, std::span<const core::Vector3> vectors) {
    const auto bad = std::ranges::find_if(vectors, [](const core::Vector3 &vector) { return !vector.allFinite(); });
    if (bad != vectors.end())
        file.refuse(path, fmt::format("row {} is not finite", bad - vectors.begin()));
}

/// Rows of node numbers, each checked.
template <std::size_t columns>
std::vector<std::array<int, columns>> node_numbers(const InputFile &file, const std::string &path,
                                                   std::size_t num_nodes) {
    auto rows = file.dataset<std::array<int, columns>>(path);
    // std::array lies in memory like its entries, one row behind the other.
    check_indices(file, path, {rows.empty() ? nullptr : rows.front().data(), columns * rows.size()},
                  static_cast<int>(columns), 0, num_nodes);
    return rows;
}

/// Expected number of rows, or nothing where the file decides.
using Count = std::optional<std::size_t>;

/// A record as a description has it: constant where it is written.
template <class At, class Record> using Of = std::conditional_t<At::reads, Record, const Record>;

/// Whether a group remembers the order of its children.
enum class Order { by_name, kept };

inline std::string path_below(const std::string &group, const std::string &name) {
    return group == "/" ? group + name : fmt::format("{}/{}", group, name);
}

/// A place in a file, a group or a dataset, and what GroupWriter and GroupReader have in common.
template <class File> class Place {
  public:
    explicit Place(File &file, std::string path = "/") : file_(&file), path_(std::move(path)) {}

    File &file() const { return *file_; }
    const std::string &path() const { return path_; }
    std::string path_of(const std::string &name) const { return path_below(path_, name); }

  private:
    File *file_;
    std::string path_;
};

/// Writes what is described.
class GroupWriter : public Place<OutputFile> {
  public:
    static constexpr bool reads = false;
    using Place::Place;

    /// Whether a part of a record is in the file, a dataset, a group or an attribute. What files of earlier versions
    /// lack is asked for in this way too, and always written.
    bool has(const std::string &, bool is_written = true) const { return is_written; }
    /// Refuses a file, at the place or at one below it.
    void check(bool, const std::string &) const {}
    void check(bool, const std::string &, const std::string &) const {}

    GroupWriter group(const std::string &name, Order order = Order::by_name) const {
        file().group(path_of(name), order == Order::kept);
        return on(name);
    }
    /// A group that is there, or a dataset, for its attributes.
    GroupWriter on(const std::string &name) const { return GroupWriter(file(), path_of(name)); }
    /// A group for each record, named by its member.
    template <class Record, class Describe>
    void each(const std::vector<Record> &records, std::string Record::*name, Describe describe,
              Order order = Order::by_name) const {
        for (const Record &record : records)
            describe(group(record.*name, order), record);
    }
    /// The same, named by its number.
    template <class Record, class Describe>
    void each(const std::vector<Record> &records, Describe describe, Order order = Order::by_name) const {
        for (std::size_t n = 0; n < records.size(); ++n)
            describe(group(std::to_string(n), order), records[n]);
    }
    /// A part that is there if the file has what is named: the first thing that is described of it.
    template <class Part, class Describe>
    void optional(const std::string &, const std::optional<Part> &part, Describe describe) const {
        if (part)
            describe(*part);
    }

    // --- attributes

    void text(const std::string &name, const std::string &value) const { file().text(path(), name, value); }
    void texts(const std::string &name, const std::vector<std::string> &values, const Count & = {}) const {
        file().texts(path(), name, values);
    }
    /// The word of an enumeration.
    template <class Value> void word(const std::string &name, Value value) const { text(name, to_string(value)); }
    void number(const std::string &name, double value) const { file().number(path(), name, value); }
    void number(const std::string &name, const std::optional<double> &value) const {
        if (value)
            number(name, *value);
    }
    /// A whole number in [lowest, highest].
    template <class Integer>
    void integer(const std::string &name, Integer value, std::int64_t /*lowest*/ = 0,
                 std::int64_t /*highest*/ = 0) const {
        file().integer(path(), name, value);
    }

    // --- datasets

    template <class T>
    void rows(const std::string &name, const std::vector<T> &values, const std::string &units = "",
              const Count & = {}) const {
        file().dataset(path_of(name), values, units);
    }
    template <class T, std::size_t size>
    void rows(const std::string &name, const std::array<T, size> &values, const std::string &units = "") const {
        rows(name, std::vector<T>(values.begin(), values.end()), units);
    }
    /// Values, each of which is a row.
    template <class... Values>
    void rows_of(const std::string &name, const std::string &units, const Values &...values) const {
        rows(name, std::vector{values...}, units);
    }
    /// Rows in blocks of equally many, a dataset with one more dimension.
    template <class T>
    void blocks(const std::string &name, const std::vector<T> &values, std::size_t rows_per_block,
                const std::string &units = "", const Count & = {}) const {
        file().blocks(path_of(name), values, rows_per_block, units);
    }
    void matrix(const std::string &name, const std::vector<std::vector<double>> &values, std::size_t columns,
                const std::string &units = "", const Count & = {}) const {
        std::vector<double> all;
        for (const auto &row : values)
            all.insert(all.end(), row.begin(), row.end());
        blocks(name, all, columns, units);
    }
    /// Numbers of nodes in [0, num_nodes).
    template <std::size_t columns>
    void node_numbers(const std::string &name, const std::vector<std::array<int, columns>> &values,
                      std::size_t /*num_nodes*/) const {
        rows(name, values);
    }
    /// Indices from `first` on into a list of names, which is an attribute of the dataset.
    void named_indices(const std::string &name, const std::vector<int> &values, const std::vector<std::string> &names,
                       std::size_t /*num_rows*/, int /*first*/) const {
        rows(name, values);
        on(name).texts("names", names);
    }
    /// Refuses an index that is not in [first, end).
    void within(const std::string &, std::span<const int>, int /*first*/, std::size_t /*end*/) const {}
    /// Refuses what is not finite.
    void finite(const std::string &, std::span<const core::Vector3>) const {}
};

/// Reads what is described, and checks it.
class GroupReader : public Place<const InputFile> {
  public:
    static constexpr bool reads = true;
    using Place::Place;

    bool has(const std::string &name, bool /*is_written*/ = true) const {
        return file().has_attribute(path(), name) || file().has(path_of(name));
    }
    void check(bool is_right, const std::string &fault) const {
        if (!is_right)
            file().refuse(path(), fault);
    }
    void check(bool is_right, const std::string &name, const std::string &fault) const {
        if (!is_right)
            file().refuse(path_of(name), fault);
    }

    GroupReader group(const std::string &name, Order /*order*/ = Order::by_name) const { return on(name); }
    GroupReader on(const std::string &name) const { return GroupReader(file(), path_of(name)); }
    template <class Record, class Describe>
    void each(std::vector<Record> &records, std::string Record::*name, Describe describe,
              Order /*order*/ = Order::by_name) const {
        for (const auto &child : file().children(path())) {
            Record &record = records.emplace_back();
            record.*name = child;
            describe(on(child), record);
        }
    }
    template <class Record, class Describe>
    void each(std::vector<Record> &records, Describe describe, Order /*order*/ = Order::by_name) const {
        for (const auto &child : file().children(path()))
            describe(on(child), records.emplace_back());
    }
    template <class Part, class Describe>
    void optional(const std::string &first, std::optional<Part> &part, Describe describe) const {
        if (has(first))
            describe(part.emplace());
    }

    void text(const std::string &name, std::string &value) const { value = file().text(path(), name); }
    void texts(const std::string &name, std::vector<std::string> &values, const Count &count = {}) const {
        values = file().texts(path(), name);
        check(!count || values.size() == *count,
              fmt::format("attribute {} has {} entries instead of {}", name, values.size(), count.value_or(0)));
    }
    template <class Value> void word(const std::string &name, Value &value) const {
        value = value_of<Value>(name, file().text(path(), name));
    }
    void number(const std::string &name, double &value) const { value = file().number(path(), name); }
    void number(const std::string &name, std::optional<double> &value) const {
        if (has(name))
            number(name, value.emplace());
    }
    template <class Integer>
    void integer(const std::string &name, Integer &value, std::int64_t lowest = std::numeric_limits<Integer>::min(),
                 std::int64_t highest = std::numeric_limits<Integer>::max()) const {
        const auto found = file().integer(path(), name);
        check(found >= lowest && found <= highest,
              fmt::format("attribute {} is {}, which is not in [{}, {}]", name, found, lowest, highest));
        value = static_cast<Integer>(found);
    }

    template <class T>
    void rows(const std::string &name, std::vector<T> &values, const std::string & = "",
              const Count &count = {}) const {
        values = file().dataset<T>(path_of(name), count);
    }
    template <class T, std::size_t size>
    void rows(const std::string &name, std::array<T, size> &values, const std::string & = "") const {
        std::ranges::copy(file().dataset<T>(path_of(name), size), values.begin());
    }
    template <class First, class... Values>
    void rows_of(const std::string &name, const std::string &, First &first, Values &...values) const {
        const auto all = file().dataset<First>(path_of(name), 1 + sizeof...(values));
        auto next = all.begin();
        first = *next;
        ((values = *++next), ...);
    }
    template <class T>
    void blocks(const std::string &name, std::vector<T> &values, std::size_t rows_per_block, const std::string & = "",
                const Count &num_blocks = {}) const {
        values = num_blocks ? file().blocks<T>(path_of(name), *num_blocks, rows_per_block)
                            : file().blocks<T>(path_of(name), rows_per_block);
    }
    void matrix(const std::string &name, std::vector<std::vector<double>> &values, std::size_t columns,
                const std::string & = "", const Count &num_rows = {}) const {
        std::vector<double> all;
        blocks(name, all, columns, "", num_rows);
        values.clear();
        for (auto from = all.begin(); from != all.end(); from += static_cast<std::ptrdiff_t>(columns))
            values.emplace_back(from, from + static_cast<std::ptrdiff_t>(columns));
    }
    template <std::size_t columns>
    void node_numbers(const std::string &name, std::vector<std::array<int, columns>> &values,
                      std::size_t num_nodes) const {
        values = hdf5::node_numbers<columns>(file(), path_of(name), num_nodes);
    }
    void named_indices(const std::string &name, std::vector<int> &values, std::vector<std::string> &names,
                       std::size_t num_rows, int first) const {
        on(name).texts("names", names);
        values = indices(file(), path_of(name), num_rows, first, names.size());
    }
    void within(const std::string &name, std::span<const int> values, int first, std::size_t end) const {
        check_indices(file(), path_of(name), values, 1, first, end);
    }
    void finite(const std::string &name, std::span<const core::Vector3> vectors) const {
        check_finite(file(), path_of(name), vectors);
    }

    /// @throws support::InputError for a word that the enumeration does not have
    template <class Value> Value value_of(const std::string &attribute, const std::string &word) const {
        const auto value = value_of_word<Value>(word);
        check(value.has_value(), fmt::format("attribute {} has '{}', which is none of {}", attribute,
                                             support::shown(word), fmt::join(all_words<Value>(), ", ")));
        return *value;
    }
};

} // namespace livermark::results::hdf5
