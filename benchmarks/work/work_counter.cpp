// Counts what a step of a method of the arena does, on kernels that were compiled to count: see counts.hpp. It prints
// floating point operations and bytes of one step. The arena_benchmark asks for it.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fmt/format.h>
#include <memory>
#include <string>

#include "benchmarks/work/counts.hpp"
#include "benchmarks/work/pressed_body.hpp"
#include "support/input_error.hpp"

namespace {

namespace benchmarks = livermark::benchmarks;
namespace models = livermark::models;

/// Explicit steps do the same wherever the body is, so one is taken at rest. It is as long as a frame; what would come
/// of more of them does not matter.
benchmarks::Work work_of_explicit_step(models::MovingBody &body) {
    constexpr models::Effort one_step{.steps = 1, .iterations = 1};
    body.prepare_for(one_step);
    body.advance(0.0, one_step); // fills the cache
    benchmarks::begin_counting();
    body.advance(0.0, one_step);
    return benchmarks::end_counting();
}

/// Others iterate more often where the body is deformed.
benchmarks::Work work_of_iterated_step(const models::MovingMethod &method,
                                       const std::shared_ptr<const livermark::core::Problem> &problem) {
    benchmarks::PressedBody pressed(method, problem);
    benchmarks::begin_counting();
    pressed.advance();
    return benchmarks::end_counting();
}

benchmarks::Work work_of_step(const std::string &method_name, const std::string &body_name) {
    const auto methods = models::all_moving_methods();
    const auto method = std::ranges::find(methods, method_name, &models::MovingMethod::name);
    if (method == methods.end())
        throw livermark::support::InputError(
            fmt::format("there is no method '{}'; 'livermark list methods' has all", method_name));
    const auto problem = std::make_shared<const livermark::core::Problem>(benchmarks::pressed_problem(body_name));
    const auto body = method->prepare(*problem);
    return body->least_effort() ? work_of_explicit_step(*body) : work_of_iterated_step(*method, problem);
}

} // namespace

int main(int argc, char **argv) {
    if (argc != 3) {
        fmt::print(stderr, "usage: work_counter METHOD BODY\n");
        return 2;
    }
    try {
        const auto work = work_of_step(argv[1], argv[2]);
        fmt::print("{} {}\n", work.operations, work.bytes);
    } catch (const livermark::support::InputError &error) {
        fmt::print(stderr, "{}\n", error.what());
        return 2;
    }
    return EXIT_SUCCESS;
}
