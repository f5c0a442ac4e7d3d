// A record that is described once comes back as it was written, what it does not allow is refused with its place, and
// its tables have the cells that it says.
#include <functional>
#include <gtest/gtest.h>

#include "core/support/files.hpp"
#include "results/hdf5/record_file.hpp"
#include "tests/bad_input.hpp"
#include "tests/result_folder.hpp"

namespace livermark::results::hdf5 {
namespace {

struct Part {
    std::string name;
    double size = 0.0;
    bool operator==(const Part &) const = default;
};

struct Row {
    std::string name;
    core::SolutionStatus status = core::SolutionStatus::ok;
    core::Regime regime = core::Regime::small;
    bool is_large = false;
    int number = 0;
    std::vector<double> values{};
    std::vector<core::Vector3> places{};
    bool operator==(const Row &) const = default;
};

struct Sample {
    std::string title;
    core::SolutionStatus status = core::SolutionStatus::ok;
    int count = 1;
    core::Vector3 from = core::Vector3::Zero(), until = core::Vector3::Zero();
    std::optional<double> said;
    std::optional<Part> part;
    std::vector<double> later;
    std::vector<std::array<int, 3>> triangles;
    std::vector<int> region;
    std::vector<std::string> regions;
    std::vector<Part> named, numbered;
    std::vector<Row> rows;
    bool operator==(const Sample &) const = default;
};

constexpr std::size_t num_nodes = 4, num_values = 2;

template <class At> void describe_sample(At root, Of<At, Sample> &sample) {
    const auto at = root.group("sample");
    at.text("title", sample.title);
    at.word("status", sample.status);
    at.integer("count", sample.count, 1, 9);
    at.rows_of("way", "m", sample.from, sample.until);
    at.finite("way", std::array{sample.from, sample.until});
    at.number("said", sample.said);
    at.optional("part", sample.part, [&](auto &part) { at.group("part").number("size", part.size); });
    if (at.has("later", !sample.later.empty()))
        at.rows("later", sample.later);
    at.node_numbers("triangles", sample.triangles, num_nodes);
    at.named_indices("region", sample.region, sample.regions, sample.triangles.size(), 0);
    const auto describe_part = [](auto group, auto &part) { group.number("size", part.size); };
    at.group("named", Order::kept).each(sample.named, &Part::name, describe_part);
    at.group("numbered", Order::kept).each(sample.numbered, describe_part);
    auto columns = columns_of(at.group("rows"), sample.rows);
    columns.texts("names", &Row::name);
    columns.words("statuses", &Row::status);
    columns.numbered_values("regime", &Row::regime);
    columns.column("is_large", &Row::is_large);
    columns.column("number", &Row::number, "m");
    columns.blocks("values", &Row::values, num_values);
    columns.rows("places", &Row::places, 1, "m");
    at.check(sample.count == static_cast<int>(sample.rows.size()), "rows", "are not as many as the count");
}

Sample full_sample() {
    const core::Vector3 x = core::Vector3::UnitX();
    return {.title = "one",
            .status = core::SolutionStatus::not_converged,
            .count = 2,
            .from = x,
            .until = 2.0 * x,
            .said = 0.5,
            .part = Part{"", 3.0},
            .later = {1.0, 2.0},
            .triangles = {{0, 1, 2}, {1, 2, 3}},
            .region = {1, 0},
            .regions = {"liver", "tumour"},
            .named = {{"z", 1.0}, {"a", 2.0}},
            .numbered = {{"", 4.0}},
            .rows = {{"first", core::SolutionStatus::diverged, core::Regime::large, true, 7, {1.0, 2.0}, {x}},
                     {"second", core::SolutionStatus::ok, core::Regime::small, false, 8, {3.0, 4.0}, {-x}}}};
}

class Described : public tests::ResultFolder {
  protected:
    void write(const Sample &sample, const std::function<void(OutputFile &)> &more = {}) const {
        OutputFile file;
        describe_sample(GroupWriter(file), sample);
        if (more)
            more(file);
        support::write_whole(path_, file.image());
    }
    Sample read() const {
        const InputFile file(path_, "the test");
        Sample sample;
        describe_sample(GroupReader(file), sample);
        return sample;
    }
    void expect_refused(const std::function<void(Sample &)> &spoil, const std::string &place,
                        const std::string &fault) const {
        auto sample = full_sample();
        spoil(sample);
        write(sample);
        tests::expect_input_error([&] { read(); }, {path_.string(), place + " ", fault, "`the test`"});
    }
};

TEST_F(Described, ComesBackAsItWasWritten) {
    write(full_sample());
    EXPECT_EQ(read(), full_sample());
}

TEST_F(Described, LacksWhatIsOptional) {
    auto sample = full_sample();
    sample.said.reset();
    sample.part.reset();
    sample.later.clear();
    write(sample);
    EXPECT_EQ(read(), sample);
    const InputFile file(path_);
    for (const auto *const name : {"part", "later"})
        EXPECT_FALSE(file.has(path_below("/sample", name))) << name;
    EXPECT_FALSE(file.has_attribute("/sample", "said"));
}

TEST_F(Described, KeepsWordsAsTheyAreSaid) {
    write(full_sample());
    const InputFile file(path_);
    EXPECT_EQ(file.text("/sample", "status"), "not_converged");
    EXPECT_EQ(file.texts("/sample/rows", "statuses"), (std::vector<std::string>{"diverged", "ok"}));
    EXPECT_EQ(file.texts("/sample/rows/regime", "names"), (std::vector<std::string>{"small", "large"}));
    EXPECT_EQ(file.dataset<int>("/sample/rows/regime"), (std::vector{1, 0}));
    EXPECT_EQ(file.dataset<std::uint8_t>("/sample/rows/is_large"), (std::vector<std::uint8_t>{1, 0}));
    EXPECT_EQ(file.text("/sample/rows/number", "units"), "m");
}

TEST_F(Described, RefusesWhatItDoesNotAllow) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    expect_refused([](Sample &sample) { sample.count = 10; }, "/sample", "count is 10, which is not in [1, 9]");
    expect_refused([](Sample &sample) { sample.count = 1; }, "/sample/rows", "are not as many as the count");
    expect_refused([&](Sample &sample) { sample.until.y() = nan; }, "/sample/way", "row 1 is not finite");
    expect_refused([](Sample &sample) { sample.triangles[1][0] = 4; }, "/sample/triangles", "row 1 holds 4");
    expect_refused([](Sample &sample) { sample.region[0] = 2; }, "/sample/region", "row 0 holds 2");
    expect_refused([](Sample &sample) { sample.region.pop_back(); }, "/sample/region", "has shape (1) instead of (2)");
    expect_refused([](Sample &sample) { sample.rows[0].places.clear(); }, "/sample/rows/places",
                   "has shape (1,3) instead of (2,3)");
    expect_refused(
        [](Sample &sample) {
            sample.rows[0].values = {1.0, 2.0, 3.0, 4.0};
        },
        "/sample/rows/values", "has shape (3,2) instead of (2,2)");
}

TEST_F(Described, RefusesAWordThatIsNotKnown) {
    OutputFile file;
    file.group("/rows");
    file.texts("/rows", "statuses", {"ok", "perhaps"});
    support::write_whole(path_, file.image());
    const InputFile input(path_);
    std::vector<Row> rows;
    tests::expect_input_error(
        [&] { columns_of(GroupReader(input, "/rows"), rows).words("statuses", &Row::status); },
        {path_.string(), "/rows attribute statuses has 'perhaps', which is none of ok, diverged, not_converged"});
}

TEST_F(Described, RefusesColumnsOfDifferentLengths) {
    OutputFile file;
    file.group("/rows");
    file.texts("/rows", "names", {"a", "b"});
    file.texts("/rows", "statuses", {"ok"});
    file.dataset("/rows/number", std::vector<int>{1, 2, 3}, "");
    support::write_whole(path_, file.image());
    const InputFile input(path_);
    std::vector<Row> rows;
    auto columns = columns_of(GroupReader(input, "/rows"), rows);
    columns.texts("names", &Row::name);
    tests::expect_input_error([&] { columns.words("statuses", &Row::status); },
                              {"/rows attribute statuses has 1 entries instead of 2"});
    tests::expect_input_error([&] { columns.column("number", &Row::number); },
                              {"/rows/number has shape (3) instead of (2)"});
}

TEST(Cells, AreColumnsOfAllThatHasATitle) {
    std::vector<Row> rows(2);
    rows[0] = {.name = "a", .number = 123456};
    rows[1] = {.name = "b", .status = core::SolutionStatus::diverged, .number = 2};
    const Cells cells;
    auto columns = columns_of(cells, rows);
    columns.texts("names", &Row::name, "name");
    columns.words("statuses", &Row::status, "status");
    columns.column("is_large", &Row::is_large);
    columns.column("number", &Row::number, "m", "number");
    columns.column("length", &Row::number, "m", {"length [mm]", 1e3, 1});
    columns.column("both", &Row::number, "m", {"both", [](const Row &row) { return row.name + "!"; }});
    const auto table = cells.table({"length", "names", "number", "both", "statuses"});
    EXPECT_EQ(table.rows, (std::vector<std::vector<std::string>>{{"1.2e+08", "a", "123456", "a!", "ok"},
                                                                 {"2000.0", "b", "2", "b!", "diverged"}}));
    EXPECT_EQ(table.columns[0].title, "length [mm]");
    EXPECT_TRUE(table.columns[0].is_number);
    EXPECT_FALSE(table.columns[4].is_number);
    EXPECT_THROW(cells.table({"is_large"}), std::out_of_range);
}

/// The record of a dripping tap, as results/records/<name>.hpp has one; its description is in the source beside it.
struct Drop {
    std::string place;
    double height = 0.0; ///< [m]
    int splashes = 0;
    bool operator==(const Drop &) const = default;
};
struct Drops {
    Provenance provenance;
    std::vector<Drop> drops;
};

template <class At> void describe_drops(At root, Of<At, Drops> &record) {
    auto columns = columns_of(root.group("drops"), record.drops);
    columns.texts("places", &Drop::place, "place");
    columns.column("height", &Drop::height, "m", {"height [mm]", 1e3, 1});
    columns.column("splashes", &Drop::splashes, "", "splashes");
}

/// The walk of CONTRIBUTING.md: each number is named once, and its file and its table follow.
TEST_F(Described, MakesTheFileAndTheTableOfANewRecord) {
    const Drops written{.provenance = current_provenance("tap"), .drops = {{"sink", 0.25, 3}, {"floor", 1.0, 12}}};
    const auto describe = [](auto root, auto &record) { describe_drops(root, record); };
    write_record(path_, written, describe);
    const auto read = read_record<Drops>(path_, "tap", describe);
    EXPECT_EQ(read.drops, written.drops);
    EXPECT_EQ(read.provenance, written.provenance);
    const Cells cells;
    describe_drops(cells, read);
    EXPECT_EQ(to_text(cells.table({"places", "height", "splashes"})), "place  height [mm]  splashes\n"
                                                                      "-----  -----------  --------\n"
                                                                      "sink         250.0         3\n"
                                                                      "floor       1000.0        12\n");
}

} // namespace
} // namespace livermark::results::hdf5
