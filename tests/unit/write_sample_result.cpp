// write_sample_result <result.h5> <stability.h5> <histories.h5> <calibration.h5> <small_result.h5>: the files that
// schema_test.py and vtkhdf_reader_test.py look at, and a result small enough to be printed and fuzzed.
#include "results/calibration_file.hpp"
#include "results/history_file.hpp"
#include "results/result_file.hpp"
#include "results/stability_file.hpp"
#include "tests/sample_calibration.hpp"
#include "tests/sample_result.hpp"

int main(int argc, char **argv) {
    if (argc != 6)
        return 2;
    // Enough bricks that the larger datasets are chunked and compressed, as those of a liver are.
    const auto result = livermark::tests::sample_result(1000);
    livermark::results::write_result(argv[1], result);
    livermark::results::Stability stability;
    stability.limits = {{"symplectic_euler", {1e-3, 1.1e-3}, {2e-3}}, {"explicit_euler", {}, {3e-3, 3.1e-3}}};
    livermark::results::write_stability(argv[2], stability);

    const livermark::results::StepHistory history{
        .time_step = 0.5, .time = {0.0, 0.5, 1.0}, .displacement = {1.0, 0.5, 0.1}};
    livermark::results::Histories histories;
    histories.cases = {{"as_printed_with_tumour_release",
                        "",
                        {{"mass", 1.0}, {"stiffness", 2.0}, {"damping", 3.0}},
                        0.1,
                        {history, history}},
                       {"release", "", {{"alpha", 1.0}, {"beta", 2.0}}, 0.1, {history}}};
    livermark::results::write_histories(argv[3], histories);
    livermark::results::write_calibration(argv[4], livermark::tests::sample_calibration(*result.problem.body));
    livermark::results::write_result(argv[5], livermark::tests::sample_result());
}
