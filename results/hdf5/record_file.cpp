#include "results/hdf5/record_file.hpp"

#include <cstdint>
#include <fmt/format.h>
#include <limits>

namespace livermark::results::hdf5 {

namespace {

constexpr std::int64_t schema_version = 1;

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
