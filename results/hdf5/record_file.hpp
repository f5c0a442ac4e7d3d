#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <iterator>
#include <map>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/problem.hpp"
#include "core/support/files.hpp"
#include "results/hdf5/described.hpp"
#include "results/hdf5/hdf5_io.hpp"
#include "results/records/result.hpp"
#include "results/tables/table_layout.hpp"

namespace livermark::results::hdf5 {

/// The value of a member of a member.
template <class Part, class Value> auto inside(Part part, Value value) {
    return [=](auto &record) -> auto & {
        return record.*part.*value;
    };
}

/// A column in tables: its title, and the cell of a record, which is the value times a factor with some decimals, or a
/// text of the value or of the record. Without a title it is in files alone.
template <class Record> class Shown {
  public:
    Shown() = default;
    Shown(std::string title) : title(std::move(title)) {}
    Shown(const char *title) : title(title) {}
    Shown(std::string title, double factor, int decimals)
        : title(std::move(title)), value_cell([=](double value) { return fixed(factor * value, decimals); }) {}
    template <class Cell> Shown(std::string title, Cell cell) : title(std::move(title)) {
        if constexpr (std::is_invocable_v<Cell, const Record &>)
            record_cell = std::move(cell);
        else
            value_cell = std::move(cell);
    }

    std::string title;
    std::function<std::string(double)> value_cell;
    std::function<std::string(const Record &)> record_cell;
};

/// Records of one kind as columns of a group: each has a row of every dataset, and a text of every list of texts. A
/// value is a member of the record, or a function that returns a reference to it. Where a file is read the first column
/// says how many records there are, and all others have to have as many.
template <class At, class Record> class Columns {
  public:
    Columns(At at, Of<At, std::vector<Record>> &records, const Count &count = {})
        : at_(std::move(at)), records_(&records), is_sized_(count.has_value()) {
        if constexpr (At::reads)
            records_->resize(count.value_or(0));
    }

    const At &at() const { return at_; }
    std::size_t size() const { return records_->size(); }

    /// Texts in an attribute of the group.
    template <class Value> void texts(const std::string &name, Value value, const Shown<Record> & = {}) {
        std::vector<std::string> all;
        if constexpr (!At::reads)
            all = column_of<std::string>(value);
        at_.texts(name, all, count());
        if constexpr (At::reads)
            give(all, value);
    }

    /// Words of an enumeration in an attribute of the group.
    template <class Value> void words(const std::string &name, Value value, const Shown<Record> & = {}) {
        std::vector<std::string> all;
        if constexpr (!At::reads)
            for (const auto &record : *records_)
                all.emplace_back(to_string(std::invoke(value, record)));
        at_.texts(name, all, count());
        if constexpr (At::reads) {
            std::vector<ValueOf<Value>> values;
            for (const auto &word : all)
                values.push_back(at_.template value_of<ValueOf<Value>>(name, word));
            give(values, value);
        }
    }

    /// Words in a dataset of numbers, which count the names in its attribute `names`.
    /// @param names  those that stand first there, also where no record has them
    template <class Value>
    void numbered_words(const std::string &name, Value value, std::vector<std::string> names = {}) {
        std::vector<int> numbers;
        if constexpr (!At::reads)
            for (const auto &record : *records_) {
                const std::string word = std::invoke(value, record);
                const auto found = std::ranges::find(names, word);
                numbers.push_back(static_cast<int>(found - names.begin()));
                if (found == names.end())
                    names.push_back(word);
            }
        at_.rows(name, numbers, "", count());
        at_.on(name).texts("names", names);
        if constexpr (At::reads) {
            check_indices(at_.file(), at_.path_of(name), numbers, 1, 0, names.size());
            std::vector<std::string> all;
            for (const int number : numbers)
                all.push_back(names[static_cast<std::size_t>(number)]);
            give(all, value);
        }
    }

    /// The same of an enumeration.
    template <class Value> void numbered_values(const std::string &name, Value value) {
        using Enum = ValueOf<Value>;
        if constexpr (At::reads) {
            std::vector<Word> found(size());
            Columns<At, Word> words(at_, found, count());
            words.numbered_words(name, &Word::word);
            std::vector<Enum> values;
            for (const auto &entry : found)
                values.push_back(at_.on(name).template value_of<Enum>("names", entry.word));
            give(values, value);
        } else {
            numbered_words(
                name, [&](const Record &record) { return to_string(std::invoke(value, record)); }, all_words<Enum>());
        }
    }

    /// A dataset with a row of each record. Truths and codes are bytes.
    template <class Value>
    void column(const std::string &name, Value value, const std::string &units = "", const Shown<Record> & = {}) {
        using T = ValueOf<Value>;
        using Stored = std::conditional_t<std::is_same_v<T, bool> || std::is_enum_v<T>, std::uint8_t, T>;
        std::vector<Stored> all;
        if constexpr (!At::reads)
            all = column_of<Stored>(value);
        at_.rows(name, all, units, count());
        if constexpr (At::reads)
            give(all, value);
    }

    /// A dataset with a block of rows of each record, whose value is a vector.
    template <class Value>
    void blocks(const std::string &name, Value value, std::size_t rows_per_block, const std::string &units = "") {
        auto all = joined(value);
        at_.blocks(name, all, rows_per_block, units, count());
        share_out(all, value, rows_per_block);
    }

    /// The same with the rows of all records behind each other. Another column has to come before it.
    template <class Value>
    void rows(const std::string &name, Value value, std::size_t rows_per_record, const std::string &units = "") {
        auto all = joined(value);
        at_.rows(name, all, units, rows_per_record * size());
        share_out(all, value, rows_per_record);
    }

  private:
    struct Word {
        std::string word;
    };
    template <class Value> using ValueOf = std::remove_cvref_t<std::invoke_result_t<Value, Record &>>;

    Count count() const { return is_sized_ ? Count(records_->size()) : std::nullopt; }

    template <class Stored, class Value> std::vector<Stored> column_of(Value value) const {
        std::vector<Stored> all;
        all.reserve(records_->size());
        for (const auto &record : *records_)
            all.push_back(static_cast<Stored>(std::invoke(value, record)));
        return all;
    }

    template <class Stored, class Value> void give(const std::vector<Stored> &all, Value value) {
        take_size(all.size());
        for (std::size_t r = 0; r < all.size(); ++r)
            std::invoke(value, (*records_)[r]) = static_cast<ValueOf<Value>>(all[r]);
    }

    template <class Value> ValueOf<Value> joined(Value value) const {
        ValueOf<Value> all;
        if constexpr (!At::reads)
            for (const auto &record : *records_)
                all.insert(all.end(), std::invoke(value, record).begin(), std::invoke(value, record).end());
        return all;
    }

    template <class Value> void share_out(const ValueOf<Value> &all, Value value, std::size_t rows_per_record) {
        if constexpr (At::reads) {
            if (!is_sized_)
                take_size(rows_per_record == 0 ? 0 : all.size() / rows_per_record);
            auto from = all.begin();
            for (auto &record : *records_) {
                const auto until = from + static_cast<std::ptrdiff_t>(rows_per_record);
                std::invoke(value, record).assign(from, until);
                from = until;
            }
        }
    }

    void take_size(std::size_t size) {
        if constexpr (At::reads)
            records_->resize(size);
        is_sized_ = true;
    }

    At at_;
    Of<At, std::vector<Record>> *records_;
    bool is_sized_;
};

/// A place where descriptions make columns of tables: what they say of files is left out.
class Cells {
  public:
    static constexpr bool reads = false;

    bool has(const std::string &, bool = true) const { return true; }
    const Cells &group(const std::string &) const { return *this; }
    template <class... Said> void check(const Said &...) const {}
    template <class... Said> void text(const Said &...) const {}
    template <class... Said> void number(const Said &...) const {}
    template <class... Said> void integer(const Said &...) const {}

    void add(const std::string &name, const Column &head, std::vector<std::string> cells) const {
        (*columns_)[name] = {head, std::move(cells)};
    }
    const std::pair<Column, std::vector<std::string>> &column(const std::string &name) const {
        return columns_->at(name);
    }
    /// A table of the columns of these names in files, in this order.
    Layout table(const std::vector<std::string> &names) const {
        Layout layout;
        for (const auto &name : names) {
            const auto &[head, cells] = column(name);
            layout.columns.push_back(head);
            layout.rows.resize(cells.size());
            for (std::size_t r = 0; r < cells.size(); ++r)
                layout.rows[r].push_back(cells[r]);
        }
        return layout;
    }

  private:
    std::shared_ptr<std::map<std::string, std::pair<Column, std::vector<std::string>>>> columns_ =
        std::make_shared<std::map<std::string, std::pair<Column, std::vector<std::string>>>>();
};

/// Columns of records in tables.
template <class Record> class Columns<Cells, Record> {
  public:
    Columns(Cells at, const std::vector<Record> &records, const Count & = {})
        : at_(std::move(at)), records_(&records) {}

    template <class Value> void texts(const std::string &name, Value value, const Shown<Record> &shown = {}) {
        add(name, false, shown, [&](const Record &record) { return std::string(std::invoke(value, record)); });
    }
    template <class Value> void words(const std::string &name, Value value, const Shown<Record> &shown = {}) {
        add(name, false, shown,
            [&](const Record &record) { return std::string(to_string(std::invoke(value, record))); });
    }
    template <class Value>
    void column(const std::string &name, Value value, const std::string & = "", const Shown<Record> &shown = {}) {
        if constexpr (std::is_convertible_v<std::invoke_result_t<Value, const Record &>, double>)
            add(name, true, shown, [&](const Record &record) {
                const auto number = std::invoke(value, record);
                return shown.value_cell ? shown.value_cell(static_cast<double>(number)) : fmt::format("{}", number);
            });
    }
    template <class... Said> void blocks(const Said &...) const {}

  private:
    template <class Cell> void add(const std::string &name, bool is_number, const Shown<Record> &shown, Cell cell) {
        if (shown.title.empty())
            return;
        std::vector<std::string> cells;
        for (const auto &record : *records_)
            cells.push_back(shown.record_cell ? shown.record_cell(record) : cell(record));
        at_.add(name, {shown.title, is_number}, std::move(cells));
    }

    Cells at_;
    const std::vector<Record> *records_;
};

/// Columns of a place; the kind of record follows from the vector.
template <class At, class Records> auto columns_of(At at, Records &records, const Count &count = {}) {
    return Columns<At, typename Records::value_type>(std::move(at), records, count);
}

/// Parts of several kinds of files that Livermark writes. Internal to results/.

/// The attributes of the root that say where a file comes from.
void write_provenance(OutputFile &file, const Provenance &provenance);

/// @throws support::InputError if one of them is missing or cannot be
Provenance read_provenance(const InputFile &file);

/// @throws support::InputError for a file of another version, or of another program
void check_schema(const InputFile &file);

/// @throws support::InputError for a value that no material has
void check_materials(const GroupReader &group, const std::vector<core::Material> &materials);

/// Body, load case and title of a record, as attributes of the root.
template <class At, class Record> void describe_head(At root, Record &record) {
    root.text("body", record.body);
    root.text("load_case", record.load_case);
    root.text("title", record.title);
}

/// The group /materials, a row for each region.
/// @param num_regions  nothing where the file decides
template <class At>
void describe_materials(At at, Of<At, std::vector<core::Material>> &materials, const Count &num_regions = {}) {
    const auto group = at.group("materials");
    auto columns = columns_of(group, materials, num_regions);
    columns.column("density", &core::Material::density, "kg/m^3");
    columns.column("young_modulus", &core::Material::young_modulus, "Pa");
    columns.column("poisson_ratio", &core::Material::poisson_ratio);
    if constexpr (At::reads)
        check_materials(group, materials);
}

/// Writes a file of one record and where it comes from, as write_result() writes results.
/// @param describe  of the root of the file and the record
/// @throws support::InputError if the place cannot be written to
template <class Record, class Describe>
void write_record(const std::filesystem::path &path, const Record &record, Describe describe) {
    OutputFile file;
    write_provenance(file, record.provenance);
    describe(GroupWriter(file), record);
    support::write_whole(path, file.image());
}

/// Reads what write_record wrote.
/// @param maker  the command that writes such files, for messages
/// @throws support::InputError that names the file and the dataset or attribute, and says what is wrong and what to do
template <class Record, class Describe>
Record read_record(const std::filesystem::path &path, const std::string &maker, Describe describe) {
    return read_once_tried(path, [&] {
        const InputFile file(path, maker);
        check_schema(file);
        Record record;
        record.provenance = read_provenance(file);
        describe(GroupReader(file), record);
        return record;
    });
}

} // namespace livermark::results::hdf5
