#include <algorithm>
#include <filesystem>
#include <gtest/gtest.h>
#include <string>
#include <variant>

#include "core/load_case.hpp"
#include "core/support/files.hpp"
#include "core/support/toml_input.hpp"
#include "load_cases/readers/event_reader.hpp"
#include "load_cases/readers/load_case_reader.hpp"

namespace livermark {
namespace {

TEST(Events, HaveAReaderForEachKind) {
    const auto num_read =
        std::ranges::count_if(load_cases::all_events(), [](const auto &event) { return event.begin || event.read; });
    EXPECT_EQ(num_read, static_cast<std::ptrdiff_t>(std::variant_size_v<core::EventKind>));
}

TEST(Events, AreInTheLoadCasesOfTheirFolder) {
    int num_seen = 0;
    for (const auto &event : load_cases::all_events())
        if (event.folder)
            for (const auto &entry : std::filesystem::directory_iterator(support::root_folder() / event.folder)) {
                const auto kind = load_cases::load_case_kind(entry.path());
                EXPECT_TRUE(kind.is_for(event.command)) << entry.path();
                EXPECT_GE(kind.depends_on_time, event.in_time) << entry.path();
                ++num_seen;
            }
    EXPECT_GT(num_seen, 0);
}

TEST(EventSets, KnowTheKindsOfALoadCase) {
    core::LoadCase load_case;
    EXPECT_TRUE(load_case.kinds().empty());
    EXPECT_FALSE(load_case.in_time());
    load_case.touching = core::TouchingTool{.shape = 0.01, .press = {0.0, 0.0, -0.002}};
    EXPECT_TRUE(load_case.kinds().has<core::TouchingTool>());
    EXPECT_FALSE(load_case.in_time()) << "contact is a part of the static solution";
    EXPECT_EQ(load_case.contact_depth(), 0.002);
    load_case.slow_history = core::SlowHistory{};
    EXPECT_TRUE(load_case.in_time());
    const auto both = core::EventSet::of<core::SlowHistory, core::TouchingTool>();
    EXPECT_TRUE(both.has_all_of(load_case.kinds()));
    EXPECT_TRUE(core::EventSet::all().has_all_of(both));
    EXPECT_FALSE((core::EventSet::of<core::SlowHistory, core::Release, core::ToolMotion>().has_all_of(both)));
}

} // namespace
} // namespace livermark
