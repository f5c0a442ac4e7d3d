#include "results/hdf5/io/read_apart.hpp"

#include <string>
#include <system_error>

#include "results/hdf5/io/hdf5_checks.hpp"
#include "support/processes/own_process.hpp"

namespace livermark::results::hdf5 {

void try_apart(const std::filesystem::path &path, const std::function<void()> &read) {
    if (std::error_code error; !std::filesystem::is_regular_file(path, error) || !has_checksums(path))
        return; // which the reader says better, before HDF5 sees it
    check_not_in_use(path);
    constexpr double bytes_per_byte = 100.0; // compressed, and read into other types
    support::in_own_process(path, support::limits_for(path, bytes_per_byte), [&] {
        read();
        check_all_parts(path);
        return std::string();
    });
}

} // namespace livermark::results::hdf5
