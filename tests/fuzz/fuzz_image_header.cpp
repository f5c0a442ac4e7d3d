#include <array>

#include "meshes/segmentation/images/image_headers.hpp"
#include "tests/fuzz/fuzz_target.hpp"

/// Everything that is checked in an image before and after ITK reads it. The first byte says what the file is called.
void livermark::fuzz::read(Input input) {
    using namespace livermark::segmentation;
    if (input.empty())
        return;
    constexpr std::array endings{".nii", ".nii.gz", ".mha", ".mhd", ".nrrd", ".dcm"};
    const auto file = as_file(input.subspan(1), endings.at(input.front() % endings.size()));
    constexpr double num_voxels = 64.0;
    check_text_of_header(file);
    if (const auto header = read_nifti_header(file)) {
        doubts_about_forms(*header);
        off_right_angles(header->sform);
    }
    check_all_there(file, num_voxels, num_voxels);
    check_dicom_pixels(file, static_cast<std::size_t>(num_voxels));
}
