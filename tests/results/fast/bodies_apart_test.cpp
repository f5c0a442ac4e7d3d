#include "results/hdf5/result_file.hpp"

#include <gtest/gtest.h>
#include <memory>

#include "tests/samples/records/sample_result.hpp"

namespace livermark::results {
namespace {

Result with_a_larger_body() {
    auto result = tests::sample_result();
    auto body = *result.problem.body;
    for (auto &point : body.mesh.points)
        point *= 1.1;
    result.problem.body = std::make_shared<core::Body>(body);
    return result;
}

TEST(BodiesApart, OneBodyKeepsItsName) {
    std::vector results{tests::sample_result(), tests::sample_result()};
    const auto name = results[0].problem.body->name;
    EXPECT_TRUE(tell_bodies_apart(results).empty());
    for (const auto &result : results)
        EXPECT_EQ(result.problem.body->name, name);
}

TEST(BodiesApart, MeshesOfOneNameAreDifferentBodies) {
    std::vector results{tests::sample_result(), with_a_larger_body(), tests::sample_result()};
    const auto name = results[0].problem.body->name;
    const auto sentences = tell_bodies_apart(results);
    ASSERT_EQ(sentences.size(), 1U);
    EXPECT_NE(sentences[0].find("2 different bodies have the name " + name), std::string::npos) << sentences[0];
    EXPECT_EQ(results[0].problem.body->name, results[2].problem.body->name);
    EXPECT_NE(results[0].problem.body->name, results[1].problem.body->name);
    EXPECT_TRUE(results[1].problem.body->name.starts_with(name + "#"));
    EXPECT_NE(sentences[0].find(results[1].problem.body->name), std::string::npos);
}

} // namespace
} // namespace livermark::results
