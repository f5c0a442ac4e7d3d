#include "studies/run/work/worker_messages.hpp"

#include <gtest/gtest.h>

namespace livermark::studies {
namespace {

TEST(WorkerMessages, ArriveAsTheyWereSent) {
    using enum MessageKind;
    for (const auto kind : {step, time, result, failure})
        for (const std::string about :
             {"liver / palpation", "", "two\nlines  and two blanks", " begins with a blank"}) {
            const WorkerMessage message(to_text(kind, 17, about, 0.015625));
            EXPECT_EQ(message.kind, kind);
            EXPECT_EQ(message.problem, 17u);
            EXPECT_EQ(message.seconds, 0.015625);
            EXPECT_EQ(message.about, about);
        }
}

} // namespace
} // namespace livermark::studies
