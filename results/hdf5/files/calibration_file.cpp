#include "results/hdf5/files/calibration_file.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "results/hdf5/file_parts.hpp"
#include "results/hdf5/io/read_apart.hpp"
#include "results/hdf5/io/schema.hpp"
#include "support/whole_file.hpp"

namespace livermark::results {

namespace {

constexpr const char *maker = "livermark calibrate";

std::vector<double> positive(const hdf5::InputFile &file, const std::string &path, const std::vector<double> &rows) {
    const auto bad = std::ranges::find_if(rows, [](double value) { return !(value > 0.0 && std::isfinite(value)); });
    if (bad != rows.end())
        file.refuse(path, fmt::format("row {} is {}, which is not positive and finite", bad - rows.begin(), *bad));
    return rows;
}

void check_kind(const hdf5::InputFile &file) {
    if (!file.has_attribute("/", "schema_version") || !file.has("/springs"))
        file.refuse("/", "holds no calibration");
    if (const auto found = file.integer("/", "schema_version"); found != schema_version)
        file.refuse("/", fmt::format("attribute schema_version is {}, and this program reads version {}", found,
                                     schema_version));
}

} // namespace

void write_calibration(const std::filesystem::path &path, const Calibration &calibration) {
    hdf5::OutputFile file;
    hdf5::write_provenance(file, calibration.provenance);
    file.text("/", "body", calibration.body);
    file.text("/", "spring_law", calibration.spring_law);
    file.text("/", "volume_term", calibration.volume_term);
    file.text("/", "reference", calibration.reference);
    file.text("/", "held", calibration.constrained);
    file.integer("/", "seed", calibration.seed);
    file.integer("/", "iterations", calibration.iterations);
    file.number("/", "penalty", calibration.penalty);

    hdf5::write_materials(file, calibration.springs.materials);
    file.group("/springs");
    file.dataset("/springs/edges", calibration.springs.edges, "");
    file.dataset("/springs/rest_length", calibration.springs.rest_length, "m");
    file.dataset("/springs/start_stiffness", calibration.start_stiffness, "N/m");
    file.dataset("/springs/stiffness", calibration.springs.stiffness, "N/m");
    file.group("/loads");
    file.dataset("/loads/held_out", calibration.held_out, "");
    file.dataset("/loads/error_before", calibration.error_before, "");
    file.dataset("/loads/error_after", calibration.error_after, "");
    support::write_whole(path, file.image());
}

namespace {

Calibration calibration_in(const std::filesystem::path &path) {
    const hdf5::InputFile file(path, maker);
    check_kind(file);
    Calibration calibration;
    calibration.body = file.text("/", "body");
    calibration.spring_law = file.text("/", "spring_law");
    calibration.volume_term = file.text("/", "volume_term");
    calibration.reference = file.text("/", "reference");
    calibration.constrained = file.text("/", "held");
    calibration.seed = file.integer("/", "seed");
    calibration.iterations = file.integer("/", "iterations");
    calibration.penalty = file.number("/", "penalty");

    auto &springs = calibration.springs;
    springs.origin = path.string();
    springs.materials = hdf5::read_materials(file, file.dataset<double>("/materials/density").size());
    springs.edges = file.dataset<std::array<int, 2>>("/springs/edges");
    const auto of_springs = [&](const std::string &name) {
        return positive(file, name, file.dataset<double>(name, springs.edges.size()));
    };
    springs.rest_length = of_springs("/springs/rest_length");
    springs.stiffness = of_springs("/springs/stiffness");
    calibration.start_stiffness = of_springs("/springs/start_stiffness");
    calibration.held_out = file.dataset<std::uint8_t>("/loads/held_out");
    calibration.error_before = file.dataset<double>("/loads/error_before", calibration.held_out.size());
    calibration.error_after = file.dataset<double>("/loads/error_after", calibration.held_out.size());
    return calibration;
}

} // namespace

Calibration read_calibration(const std::filesystem::path &path) {
    return hdf5::read_once_tried(path, [&] { return calibration_in(path); });
}

} // namespace livermark::results
