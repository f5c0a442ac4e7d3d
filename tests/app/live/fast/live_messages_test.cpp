#include "app/live/messages.hpp"

#include <array>
#include <cstring>
#include <gtest/gtest.h>
#include <limits>
#include <span>
#include <vector>

#include "app/live/parameters.hpp"
#include "core/support/input_error.hpp"
#include "msm/spring_law.hpp"
#include "tests/app/live/body_message.hpp"
#include "tests/app/live/box_scene.hpp"

namespace livermark::live {
namespace {

TEST(LiveMessages, SayWhatTheCallsSay) {
    const BoxScene box;
    const auto told = scene_of(body_message(box.body, box.is_constrained));
    Scene called(box.body, box.is_constrained);
    const auto laws = msm::all_spring_laws();
    const auto chosen = called.choose(settings(laws[0].name));
    const auto answer = reply(*told, std::vector<double>{1, 0, 1, 5e3, 0.45, 40.0, 0.0, 0.0});
    std::array<double, 7> said{};
    ASSERT_EQ(answer.size(), sizeof said);
    std::memcpy(said.data(), answer.data(), sizeof said);
    EXPECT_EQ(said, (std::array<double, 7>{chosen.time_step, chosen.longest_time_step, chosen.critical_time_step,
                                           chosen.pressed_time_step, 1.0 * chosen.num_springs,
                                           chosen.unscaled_time_step, static_cast<double>(chosen.limit)}));

    const auto tool = box.poke(0.004);
    const auto frame = called.move(tool, 600);
    const auto bytes =
        reply(*told, std::vector<double>{2, 1, tool.target.x(), tool.target.y(), tool.target.z(), tool.radius, 0, 600});
    std::array<double, 20> head{};
    ASSERT_GT(bytes.size(), sizeof head);
    std::memcpy(head.data(), bytes.data(), sizeof head);
    EXPECT_EQ(head[0], frame.time);
    EXPECT_EQ(Vector3(head[4], head[5], head[6]), frame.force);
    EXPECT_EQ(head[10], 0.0) << "tractions of a ball are even on each facet";
    EXPECT_EQ(head[11], frame.indentation);
    EXPECT_EQ(head[13], frame.largest_speed);
    EXPECT_GT(frame.largest_speed, 0.0);
    EXPECT_EQ(head[16], 1.0 * called.num_evaluations());
    EXPECT_GT(head[16], 600.0) << "steps are divided where a tool is just taken up";
    EXPECT_EQ(head[17], box.body.mesh.num_nodes());
    EXPECT_EQ(bytes.size(), sizeof head + sizeof(double) * 4 * (frame.load.nodes.size() + frame.load.triangles.size()) +
                                sizeof(float) * 3 * box.body.mesh.num_nodes());
    // A plate.
    const Tool plate{.kind = ToolKind::probe,
                     .target = tool.target - Vector3(0.0, 0.0, 0.006),
                     .radius = 0.008,
                     .inwards = {0.0, 0.1, -1.0},
                     .face = core::ToolFace::square};
    const auto pressed = called.move(plate, 300);
    const std::vector<double> message{9,  plate.target.x(), plate.target.y(), plate.target.z(), 0.0, 0.1, -1.0, 0.008,
                                      300};
    const auto plate_reply = reply(*told, message);
    ASSERT_GT(plate_reply.size(), sizeof head);
    std::memcpy(head.data(), plate_reply.data(), sizeof head);
    EXPECT_EQ(Vector3(head[1], head[2], head[3]), pressed.tool);
    EXPECT_EQ(Vector3(head[4], head[5], head[6]), pressed.force);
    EXPECT_GT(pressed.force.norm(), 0.0);
    for (std::size_t length = 1; length < message.size(); ++length)
        EXPECT_THROW(reply(*told, std::span(message).first(length)), support::InputError) << length;
    EXPECT_TRUE(reply(*told, std::vector<double>{3}).empty());
    for (const auto &name : spring_names())
        EXPECT_NE(joined_spring_names().find(name), std::string::npos);
}

TEST(LiveMessages, AreRefusedWhenTheyAreCutOffOrLongerOrOfAnotherKind) {
    const BoxScene box;
    const auto whole = body_message(box.body, box.is_constrained);
    for (std::size_t length = 0; length < whole.size(); length += 1 + length / 20)
        EXPECT_THROW(scene_of(std::span(whole).first(length)), support::InputError) << length;
    auto longer = whole;
    longer.push_back(0.0);
    EXPECT_THROW(scene_of(longer), support::InputError);
    const auto scene = scene_of(whole);
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    for (const std::vector<double> &message : {std::vector<double>{},
                                               {0},
                                               {4}, // nothing has been chosen
                                               {5},
                                               {6},
                                               {7},
                                               {nan},
                                               {1.5},
                                               {1e300},
                                               {3, 0},
                                               {4, 0},
                                               {5, 0},
                                               {1, 0},
                                               {1, -1, 1, 5e3, 0.45, 10, 0, 0},
                                               {1, 99, 1, 5e3, 0.45, 10, 0, 0},
                                               {1, 0, 1, 5e3, 0.45, 10, 0, 0, 0},
                                               {2, 0, 0, 0, 0, 0, 0}})
        EXPECT_THROW(reply(*scene, message), support::InputError);
    for (const double count : {-1.0, 0.5, nan, 1e18}) {
        auto changed = whole;
        changed[1] = count;
        EXPECT_THROW(scene_of(changed), support::InputError) << count;
    }
}

} // namespace
} // namespace livermark::live
