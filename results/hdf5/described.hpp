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
#include "results/hdf5/hdf5_io.hpp"
#include "results/records/arena.hpp"

/// A record is described once, and the description writes it, reads it and makes the columns of its tables. It is a
/// template over the place, GroupWriter and GroupReader in a file or Cells of tables (record_file.hpp), which have the
/// same functions: the name in the file first, then what stands there.
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

template <> struct Words<core::ToolFace> {
    static constexpr std::array all{core::ToolFace::ball, core::ToolFace::round, core::ToolFace::square};
};

template <> struct Words<core::Regime> { static constexpr std::array all{core::Regime::small, core::Regime::large}; };

template <> struct Words<core::SolutionStatus> {
    static constexpr std::array all{core::SolutionStatus::ok, core::SolutionStatus::diverged,
                                    core::SolutionStatus::not_converged};
};

template <> struct Words<ArenaOutcome> {
    static constexpr std::array all{ArenaOutcome::ok, ArenaOutcome::too_slow, ArenaOutcome::diverged};
};

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

/// Expected number of rows, or nothing where the file decides.
using Count = std::optional<std::size_t>;

/// A record as a description has it: constant where it is written.
template <class At, class Record> using Of = std::conditional_t<At::reads, Record, const Record>;

/// Whether a group remembers the order of its children.
enum class Order { by_name, kept };

inline std::string path_below(const std::string &group, const std::string &name) {
    return group == "/" ? group + name : fmt::format("{}/{}", group, name);
}

/// A place in a file, a group or a dataset: in an OutputFile it writes what is described, in a const InputFile it reads
/// it and checks it.
template <class File> class Group {
  public:
    static constexpr bool reads = std::is_const_v<File>;

    explicit Group(File &file, std::string path = "/") : file_(&file), path_(std::move(path)) {}

    File &file() const { return *file_; }
    const std::string &path() const { return path_; }
    std::string path_of(const std::string &name) const { return path_below(path_, name); }

    /// Whether a part of a record is in the file, a dataset, a group or an attribute. Parts that files of earlier
    /// versions lack are asked for in this way too, and always written.
    bool has(const std::string &name, [[maybe_unused]] bool is_written = true) const {
        if constexpr (reads)
            return file().has_attribute(path(), name) || file().has(path_of(name));
        else
            return is_written;
    }
    /// Refuses a file, at the place or at one below it.
    void check([[maybe_unused]] bool is_right, [[maybe_unused]] const std::string &fault) const {
        if constexpr (reads)
            if (!is_right)
                file().refuse(path(), fault);
    }
    void check(bool is_right, const std::string &name, const std::string &fault) const {
        on(name).check(is_right, fault);
    }

    Group group(const std::string &name, [[maybe_unused]] Order order = Order::by_name) const {
        if constexpr (!reads)
            file().group(path_of(name), order == Order::kept);
        return on(name);
    }
    /// A group that is there, or a dataset, for its attributes.
    Group on(const std::string &name) const { return Group(file(), path_of(name)); }
    /// A group for each record, named by its member.
    template <class Records, class Record, class Describe>
    void each(Records &records, std::string Record::*name, Describe describe, Order order = Order::by_name) const {
        if constexpr (reads)
            for (const auto &child : file().children(path())) {
                auto &record = records.emplace_back();
                record.*name = child;
                describe(on(child), record);
            }
        else
            for (auto &record : records)
                describe(group(record.*name, order), record);
    }
    /// The same, named by its number.
    template <class Records, class Describe>
    void each(Records &records, Describe describe, Order order = Order::by_name) const {
        if constexpr (reads)
            for (const auto &child : file().children(path()))
                describe(on(child), records.emplace_back());
        else
            for (std::size_t n = 0; n < records.size(); ++n)
                describe(group(std::to_string(n), order), records[n]);
    }
    /// A part that is there if the file has what is named: the first thing that is described of it.
    template <class Part, class Describe>
    void optional([[maybe_unused]] const std::string &first, Part &part, Describe describe) const {
        if constexpr (reads)
            if (has(first))
                part.emplace();
        if (part)
            describe(*part);
    }

    // --- attributes

    template <class Text> void text(const std::string &name, Text &&value) const {
        if constexpr (reads)
            value = file().text(path(), name);
        else
            file().text(path(), name, value);
    }
    template <class Texts> void texts(const std::string &name, Texts &&values, const Count &count = {}) const {
        if constexpr (reads) {
            values = file().texts(path(), name);
            check(!count || values.size() == *count,
                  fmt::format("attribute {} has {} entries instead of {}", name, values.size(), count.value_or(0)));
        } else {
            file().texts(path(), name, values);
        }
    }
    /// The word of an enumeration.
    template <class Value> void word(const std::string &name, Value &&value) const {
        if constexpr (reads)
            value = value_of<std::remove_cvref_t<Value>>(name, file().text(path(), name));
        else
            text(name, to_string(value));
    }
    template <class Value> void number(const std::string &name, Value &&value) const {
        if constexpr (std::is_same_v<std::remove_cvref_t<Value>, std::optional<double>>)
            optional(name, value, [&](auto &known) { number(name, known); });
        else if constexpr (reads)
            value = file().number(path(), name);
        else
            file().number(path(), name, value);
    }
    /// A whole number in [lowest, highest].
    template <class Value, class Integer = std::remove_cvref_t<Value>>
    void integer(const std::string &name, Value &&value,
                 [[maybe_unused]] std::int64_t lowest = std::numeric_limits<Integer>::min(),
                 [[maybe_unused]] std::int64_t highest = std::numeric_limits<Integer>::max()) const {
        if constexpr (reads) {
            const auto found = file().integer(path(), name);
            check(found >= lowest && found <= highest,
                  fmt::format("attribute {} is {}, which is not in [{}, {}]", name, found, lowest, highest));
            value = static_cast<Integer>(found);
        } else {
            file().integer(path(), name, value);
        }
    }

    // --- datasets

    /// A vector, or an array, whose size is checked.
    template <class Rows>
    void rows(const std::string &name, Rows &&values, const std::string &units = "", const Count &count = {}) const {
        using Value = typename std::remove_cvref_t<Rows>::value_type;
        constexpr bool is_vector = std::is_same_v<std::remove_cvref_t<Rows>, std::vector<Value>>;
        if constexpr (reads && is_vector)
            values = file().template dataset<Value>(path_of(name), count);
        else if constexpr (reads)
            std::ranges::copy(file().template dataset<Value>(path_of(name), values.size()), values.begin());
        else if constexpr (is_vector)
            file().dataset(path_of(name), values, units);
        else
            rows(name, std::vector<Value>(values.begin(), values.end()), units);
    }
    /// Values, each of which is a row.
    template <class First, class... Rest>
    void rows_of(const std::string &name, const std::string &units, First &first, Rest &...rest) const {
        if constexpr (reads) {
            const auto all = file().template dataset<First>(path_of(name), 1 + sizeof...(rest));
            auto next = all.begin();
            first = *next;
            ((rest = *++next), ...);
        } else {
            rows(name, std::vector{first, rest...}, units);
        }
    }
    /// Rows in blocks of equally many, a dataset with one more dimension.
    template <class Rows>
    void blocks(const std::string &name, Rows &values, std::size_t rows_per_block, const std::string &units = "",
                const Count &num_blocks = {}) const {
        using Value = typename Rows::value_type;
        if constexpr (!reads)
            file().blocks(path_of(name), values, rows_per_block, units);
        else if (num_blocks)
            values = file().template blocks<Value>(path_of(name), *num_blocks, rows_per_block);
        else
            values = file().template blocks<Value>(path_of(name), rows_per_block);
    }
    /// Numbers of nodes in [0, num_nodes).
    template <class Rows>
    void node_numbers(const std::string &name, Rows &values, [[maybe_unused]] std::size_t num_nodes) const {
        constexpr auto columns = std::tuple_size_v<typename Rows::value_type>;
        rows(name, values);
        if constexpr (reads) // std::array lies in memory like its entries, one row behind the other
            check_indices(file(), path_of(name),
                          {values.empty() ? nullptr : values.front().data(), columns * values.size()},
                          static_cast<int>(columns), 0, num_nodes);
    }
    /// Indices from `first` on into a list of names, which is an attribute of the dataset.
    template <class Indices, class Names>
    void named_indices(const std::string &name, Indices &values, Names &names, std::size_t num_rows, int first) const {
        if constexpr (reads)
            on(name).texts("names", names);
        rows(name, values, "", num_rows);
        within(name, values, first, names.size());
        if constexpr (!reads)
            on(name).texts("names", names);
    }
    /// Refuses an index that is not in [first, end).
    void within([[maybe_unused]] const std::string &name, [[maybe_unused]] std::span<const int> values,
                [[maybe_unused]] int first, [[maybe_unused]] std::size_t end) const {
        if constexpr (reads)
            check_indices(file(), path_of(name), values, 1, first, end);
    }
    /// Refuses vectors that are not finite.
    void finite([[maybe_unused]] const std::string &name,
                [[maybe_unused]] std::span<const core::Vector3> vectors) const {
        if constexpr (reads) {
            const auto bad = std::ranges::find_if(vectors, [](const auto &vector) { return !vector.allFinite(); });
            check(bad == vectors.end(), name, fmt::format("row {} is not finite", bad - vectors.begin()));
        }
    }

    /// @throws support::InputError for a word that the enumeration does not have
    template <class Value> Value value_of(const std::string &attribute, const std::string &word) const {
        const auto found =
            std::ranges::find_if(Words<Value>::all, [&](const Value value) { return word == to_string(value); });
        check(found != Words<Value>::all.end(), fmt::format("attribute {} has '{}', which is none of {}", attribute,
                                                            support::shown(word), fmt::join(all_words<Value>(), ", ")));
        return *found;
    }

  private:
    File *file_;
    std::string path_;
};

using GroupWriter = Group<OutputFile>;
using GroupReader = Group<const InputFile>;

} // namespace livermark::results::hdf5
