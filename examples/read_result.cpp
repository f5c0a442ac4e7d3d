// Prints the largest displacement of each model of a result file.
//
//   h5c++ -std=c++20 examples/read_result.cpp -lhdf5_hl -o read_result
//   ./read_result results/runs/liver_healthy/palpation.h5
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <hdf5.h>
#include <hdf5_hl.h>
#include <string>
#include <vector>

herr_t print_model(hid_t solutions, const char *name, const H5L_info_t *, void *) {
    const std::string path = std::string(name) + "/displacement";
    hsize_t shape[2]{};
    if (H5LTget_dataset_info(solutions, path.c_str(), shape, nullptr, nullptr) < 0)
        return -1;
    std::vector<double> u(shape[0] * shape[1]);
    H5LTread_dataset_double(solutions, path.c_str(), u.data());
    double largest = 0.0;
    for (std::size_t i = 0; i < u.size(); i += 3)
        largest = std::max(largest, std::hypot(u[i], u[i + 1], u[i + 2]));
    std::printf("%s: %.3f mm at most, %d nodes\n", name, 1000.0 * largest, static_cast<int>(shape[0]));
    return 0;
}

int main(int argc, char **argv) {
    const hid_t file = argc == 2 ? H5Fopen(argv[1], H5F_ACC_RDONLY, H5P_DEFAULT) : -1;
    const hid_t solutions = file < 0 ? -1 : H5Gopen(file, "/solutions", H5P_DEFAULT);
    if (solutions < 0)
        return std::fprintf(stderr, "usage: read_result RESULT.h5\n"), 2;
    const herr_t status = H5Literate(solutions, H5_INDEX_CRT_ORDER, H5_ITER_INC, nullptr, print_model, nullptr);
    H5Gclose(solutions);
    H5Fclose(file);
    return status < 0 ? 1 : 0;
}
