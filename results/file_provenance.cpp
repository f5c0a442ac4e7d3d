#include "results/file_provenance.hpp"

#include "results/schema.hpp"

namespace livermark::results::hdf5 {

void write_provenance(OutputFile &file, const Provenance &provenance) {
    file.integer("/", "schema_version", schema_version);
    file.text("/", "software_version", provenance.software_version);
    file.text("/", "git_commit", provenance.git_commit);
    file.text("/", "created", provenance.created);
    file.text("/", "command", provenance.command);
    file.text("/", "cpu", provenance.cpu);
    file.text("/", "compiler", provenance.compiler);
    file.text("/", "build_type", provenance.build_type);
    file.integer("/", "threads", provenance.threads);
}

} // namespace livermark::results::hdf5
