#include "studies/cohort/cohort_body.hpp"

#include <fmt/format.h>
#include <string>

#include "meshes/generators/liver/liver_generator.hpp"
#include "meshes/io/liver_body_file.hpp"
#include "support/input_error.hpp"
#include "support/toml_input.hpp"
#include "support/whole_file.hpp"

namespace livermark::studies {

namespace {

std::string body_name(int number) {
    return fmt::format("liver_variant_{}", number);
}

/// The command that makes the body, in the folder where it stands.
std::string generator_of(int number, int tetrahedra) {
    return fmt::format("livermark mesh liver --variant {}{} -o {}.msh", number,
                       tetrahedra > 0 ? fmt::format(" --tetrahedra {}", tetrahedra) : "", body_name(number));
}

/// Empty where the file does not say it.
std::string generator_in(const std::filesystem::path &file) {
    try {
        return support::parse_toml(support::read_text(file), file)["generator"].value_or(std::string());
    } catch (const support::InputError &) {
        return {};
    }
}

} // namespace

std::filesystem::path cohort_body_file(const std::filesystem::path &folder, int number) {
    return folder / (body_name(number) + ".toml");
}

void check_cohort_body(const std::filesystem::path &file, int number, int tetrahedra) {
    std::error_code error;
    if (!std::filesystem::exists(file, error))
        return;
    if (const auto generator = generator_in(file); !generator.empty() && generator != generator_of(number, tetrahedra))
        throw support::InputError(
            fmt::format("{}: this body was made by another command than `{}`; give the --tetrahedra that it was made "
                        "with, or another --output",
                        file.string(), generator_of(number, tetrahedra)));
}

void make_cohort_body(const std::filesystem::path &file, const meshes::LiverVariant &variant, int tetrahedra) {
    // The body file is written after the mesh, so where it is the mesh was whole.
    if (std::error_code error; std::filesystem::exists(file, error))
        return;
    auto mesh_file = file;
    meshes::write_liver_body(mesh_file.replace_extension(".msh"), meshes::generate_liver(variant, tetrahedra), variant,
                             generator_of(variant.number, tetrahedra));
}

results::CohortBody drawn_body(const meshes::LiverVariant &variant) {
    results::CohortBody body{.number = variant.number,
                             .name = body_name(variant.number),
                             .volume = variant.volume,
                             .body_surface = variant.body_surface,
                             .left_part = variant.left_part,
                             .front_to_back = variant.front_to_back,
                             .has_riedel_lobe = variant.has_riedel_lobe,
                             .lesions = {}};
    for (const auto &lesion : variant.lesions)
        body.lesions.push_back({lesion.center, lesion.semi_axes});
    return body;
}

} // namespace livermark::studies
