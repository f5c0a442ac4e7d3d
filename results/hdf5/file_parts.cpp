#include "results/hdf5/file_parts.hpp"

#include <fmt/format.h>
#include <limits>

#include "results/hdf5/io/schema.hpp"

namespace livermark::results::hdf5 {

namespace {

template <class At> void describe_provenance(At at, Of<At, Provenance> &provenance) {
    at.text("software_version", provenance.software_version);
    at.text("git_commit", provenance.git_commit);
    at.text("created", provenance.created);
    at.text("command", provenance.command);
    at.text("cpu", provenance.cpu);
    at.text("compiler", provenance.compiler);
    at.text("build_type", provenance.build_type);
    at.integer("threads", provenance.threads, 1);
}

} // namespace

void write_provenance(OutputFile &file, const Provenance &provenance) {
    file.integer("/", "schema_version", schema_version);
    describe_provenance(GroupWriter(file), provenance);
}

Provenance read_provenance(const InputFile &file) {
    Provenance provenance;
    describe_provenance(GroupReader(file), provenance);
    return provenance;
}

void check_schema(const InputFile &file) {
    if (!file.has_attribute("/", "schema_version"))
        file.refuse("/", "has no attribute schema_version, so this is not a result file");
    const auto found = file.integer("/", "schema_version");
    if (found != schema_version)
        file.refuse("/", fmt::format("attribute schema_version is {}, and this program reads version {}", found,
                                     schema_version));
}

void write_materials(OutputFile &file, std::span<const core::Material> materials) {
    std::vector<double> density;
    std::vector<double> young_modulus;
    std::vector<double> poisson_ratio;
    for (const core::Material &material : materials) {
        density.push_back(material.density);
        young_modulus.push_back(material.young_modulus);
        poisson_ratio.push_back(material.poisson_ratio);
    }
    file.group("/materials");
    file.dataset("/materials/density", density, "kg/m^3");
    file.dataset("/materials/young_modulus", young_modulus, "Pa");
    file.dataset("/materials/poisson_ratio", poisson_ratio, "");
}

std::vector<core::Material> read_materials(const InputFile &file, std::size_t num_regions) {
    const auto values = [&](const std::string &path, double above, double below) {
        auto rows = file.dataset<double>(path, num_regions);
        for (std::size_t r = 0; r < rows.size(); ++r)
            if (!(rows[r] > above && rows[r] < below))
                file.refuse(path, fmt::format("row {} is {}, which is not in ({}, {})", r, rows[r], above, below));
        return rows;
    };
    constexpr double infinity = std::numeric_limits<double>::infinity();
    const auto density = values("/materials/density", 0.0, infinity);
    const auto young_modulus = values("/materials/young_modulus", 0.0, infinity);
    const auto poisson_ratio = values("/materials/poisson_ratio", -1.0, 0.5);
    std::vector<core::Material> materials;
    for (std::size_t r = 0; r < num_regions; ++r)
        materials.push_back({density[r], young_modulus[r], poisson_ratio[r]});
    return materials;
}

void check_materials(const GroupReader &group, const std::vector<core::Material> &materials) {
    const auto check = [&](const char *name, double core::Material::*value, double above, double below) {
        for (std::size_t r = 0; r < materials.size(); ++r)
            group.check(materials[r].*value > above && materials[r].*value < below, name,
                        fmt::format("row {} is {}, which is not in ({}, {})", r, materials[r].*value, above, below));
    };
    constexpr double infinity = std::numeric_limits<double>::infinity();
    check("density", &core::Material::density, 0.0, infinity);
    check("young_modulus", &core::Material::young_modulus, 0.0, infinity);
    check("poisson_ratio", &core::Material::poisson_ratio, -1.0, 0.5);
}

} // namespace livermark::results::hdf5
