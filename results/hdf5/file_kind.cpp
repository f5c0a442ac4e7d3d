#include "results/hdf5/file_kind.hpp"

#include "results/hdf5/io/hdf5_io.hpp"
#include "results/hdf5/io/read_apart.hpp"

namespace livermark::results {

namespace {

FileKind kind_in(const std::filesystem::path &path) {
    const hdf5::InputFile file(path);
    if (file.has("/critical_time_step"))
        return FileKind::stability;
    if (file.has("/timings"))
        return FileKind::timings;
    if (file.has("/bodies") && file.has("/statistics"))
        return FileKind::cohort;
    if (file.has("/arena"))
        return FileKind::arena;
    if (file.has("/needles"))
        return FileKind::needle;
    if (file.has("/experiment"))
        return FileKind::experiment;
    if (file.has("/sensitivity"))
        return FileKind::sensitivity;
    if (file.has("/loads") && file.has("/springs"))
        return FileKind::calibration;
    if (file.has("/solutions") && !file.children("/solutions").empty())
        return FileKind::result;
    return file.has("/modes") ? FileKind::modes : FileKind::other;
}

} // namespace

FileKind kind_of_file(const std::filesystem::path &path) {
    return hdf5::read_once_tried(path, [&] { return kind_in(path); });
}

} // namespace livermark::results
