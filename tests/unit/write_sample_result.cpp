// write_sample_result <file.h5>: the file that vtkhdf_reader_test.py looks at.
#include "results/result_file.hpp"
#include "tests/sample_result.hpp"

int main(int argc, char **argv) {
    if (argc != 2)
        return 2;
    // Enough bricks that the larger datasets are chunked and compressed, as those of a liver are.
    livermark::results::write_result(argv[1], livermark::tests::sample_result(1000));
}
