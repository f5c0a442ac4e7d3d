#include "studies/output_folder.hpp"

#include <fmt/format.h>
#include <system_error>
#include <utility>

#include "support/input_error.hpp"
#include "support/whole_file.hpp"

namespace livermark::studies {

OutputFolder::OutputFolder(std::filesystem::path path) : path_(std::move(path)) {
    std::error_code error;
    for (auto folder = path_; !folder.empty() && !std::filesystem::exists(folder, error);
         folder = folder.parent_path()) {
        if (folder.has_filename()) // none of "runs/", whose parent is "runs"
            made_.push_back(folder);
    }
    std::filesystem::create_directories(path_, error);
    if (error)
        throw support::InputError(
            fmt::format("{}: cannot be made ({}); choose another --output", path_.string(), error.message()));
}

OutputFolder::~OutputFolder() {
    std::error_code error;
    for (const auto &folder : made_)
        if (!std::filesystem::remove(folder, error)) // something is in it, or in the one around it
            break;
}

OutputFile::OutputFile(const std::filesystem::path &folder, const std::string &name)
    : folder_(std::make_unique<OutputFolder>(folder)), path_(folder_->path() / name) {
    support::check_place(path_);
    claim_ = std::make_unique<support::FileClaim>(path_);
}

} // namespace livermark::studies
