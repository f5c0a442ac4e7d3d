#include "meshes/segmentation/images/image_headers.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fstream>
#include <map>
#include <numbers>
#include <sstream>

#include "core/support/files.hpp"
#include "core/support/input_error.hpp"

namespace livermark::segmentation {

namespace {

namespace fs = std::filesystem;
using core::Vector3;
using support::InputError;

constexpr double metres_where_no_unit_is_said = 1e-3;
constexpr const char *no_axes = "its header does not say how the image lies in the patient; its axes are taken for "
                                "left, posterior and superior, so look at the patches";

/// Metres of a unit, by its name or sign.
std::optional<double> metres_of(const std::string &unit) {
    static const std::map<std::string, double> known{
        {"", 1e-3},           {"?", 1e-3},          {"???", 1e-3},        {"mm", 1e-3},         {"millimeter", 1e-3},
        {"millimetre", 1e-3}, {"m", 1.0},           {"meter", 1.0},       {"metre", 1.0},       {"cm", 1e-2},
        {"centimeter", 1e-2}, {"centimetre", 1e-2}, {"um", 1e-6},         {"\xc2\xb5m", 1e-6},  {"\xce\xbcm", 1e-6},
        {"\xb5m", 1e-6},      {"micron", 1e-6},     {"micrometer", 1e-6}, {"micrometre", 1e-6}, {"nm", 1e-9},
        {"nanometer", 1e-9},  {"nanometre", 1e-9},  {"in", 0.0254},       {"inch", 0.0254}};
    auto word = support::lower_case(unit);
    if (const auto found = known.find(word); found != known.end())
        return found->second;
    if (word.ends_with('s'))
        word.pop_back();
    const auto found = known.find(word);
    return found == known.end() ? std::nullopt : std::optional(found->second);
}

double metres_per_unit_in(const fs::path &file, const std::string &unit) {
    if (const auto metres = metres_of(unit))
        return *metres;
    throw InputError("{}: its header gives lengths in '{}', which is no unit that is known here; write it in mm",
                     file.string(), support::shown(unit));
}

Eigen::Matrix3d with_columns_of_length_1(Eigen::Matrix3d axes) {
    axes.colwise().normalize();
    return axes;
}

/// Anatomical direction that an axis is nearest to: 1, 2 or 3, negative if it points the other way.
std::array<int, 3> nearest_directions(const Eigen::Matrix3d &axes) {
    std::array<int, 3> nearest{};
    for (int a = 0; a < 3; ++a) {
        Eigen::Index row = 0;
        axes.col(a).cwiseAbs().maxCoeff(&row);
        nearest.at(static_cast<std::size_t>(a)) = static_cast<int>(row + 1) * (axes(row, a) < 0.0 ? -1 : 1);
    }
    return nearest;
}

/// The largest angle between axes of the same number [degrees].
double degrees_between(const Eigen::Matrix3d &a, const Eigen::Matrix3d &b) {
    const double cosine = a.cwiseProduct(b).colwise().sum().minCoeff();
    return std::acos(std::clamp(cosine, -1.0, 1.0)) * 180.0 / std::numbers::pi;
}

/// Whether both forms of a header place the image alike.
void compare_forms(const Placement &qform, const Placement &sform, const fs::path &file,
                   std::vector<std::string> &remarks) {
    constexpr double noticed = 1.0, // degrees
        most = 30.0;
    const double degrees = degrees_between(qform.direction, sform.direction);
    if (qform.direction.determinant() * sform.direction.determinant() < 0.0 ||
        (nearest_directions(qform.direction) != nearest_directions(sform.direction) && degrees > most))
        throw InputError(
            "{}: the header contradicts itself: by its qform the axes point elsewhere than by its sform ({:.0f} "
            "degrees off), so left and right may be exchanged; export the image again, with one of both",
            file.string(), degrees);
    if (degrees > noticed)
        remarks.push_back(fmt::format("the axes by its qform and by its sform are {:.0f} degrees apart; check how the "
                                      "body lies",
                                      degrees));
}

HeaderGrid nifti_grid(const NiftiHeader &header, const fs::path &file) {
    HeaderGrid grid;
    if (std::ranges::all_of(header.size, [](int extent) { return extent > 0; }))
        grid.size = header.size;
    if (header.spacing.allFinite() && (header.spacing.array() > 0.0).all())
        grid.spacing = header.metres_per_unit * header.spacing;
    const Eigen::DiagonalMatrix<double, 3> ras_to_lps(-1.0, -1.0, 1.0);
    const auto add = [&](int code, const Eigen::Matrix3d &axes, const Vector3 &origin) {
        if (code > 0 && axes.allFinite() && (axes.colwise().norm().array() > 0.0).all() && origin.allFinite())
            grid.placements.push_back(
                {with_columns_of_length_1(ras_to_lps * axes), Vector3(header.metres_per_unit * (ras_to_lps * origin))});
    };
    add(header.qform_code, header.qform, header.qform_origin);
    add(header.sform_code, header.sform, header.sform_origin);
    if (grid.placements.size() == 2)
        compare_forms(grid.placements[0], grid.placements[1], file, grid.remarks);
    else if (grid.placements.empty())
        grid.remarks.emplace_back(no_axes);
    return grid;
}

using Fields = std::map<std::string, std::string>;

/// "key: value" up to an empty line; keys in lower case and without spaces, of which the format allows both.
Fields nrrd_fields(const fs::path &file) {
    constexpr std::size_t most_fields = 10000;
    Fields fields;
    std::ifstream stream(file, std::ios::binary);
    std::string line;
    std::getline(stream, line); // NRRD0005
    while (fields.size() < most_fields && std::getline(stream, line) && !trimmed(line).empty()) {
        const auto colon = line.find(':');
        if (line.starts_with('#') || colon == std::string::npos || line.substr(colon).starts_with(":="))
            continue;
        auto key = support::lower_case(line.substr(0, colon));
        std::erase_if(key, [](char c) { return c == ' ' || c == '\t'; });
        fields[key] = trimmed(line.substr(colon + 1));
    }
    return fields;
}

std::vector<double> numbers_in(const std::string &text) {
    std::vector<double> numbers;
    std::istringstream words(text);
    for (std::string word; words >> word;)
        numbers.push_back(std::strtod(word.c_str(), nullptr));
    return numbers;
}

/// Voxels along an axis; 0 for what cannot be.
int extent_of(double number) {
    constexpr double most = 1e9;
    return number >= 1.0 && number <= most ? static_cast<int>(number) : 0;
}

/// "(4,0,0) none (0,4,0)": a vector of each axis, empty where the axis has none.
std::vector<std::vector<double>> vectors_in(const std::string &text) {
    std::vector<std::vector<double>> vectors;
    for (std::size_t at = 0; at < text.size();) {
        const auto first = text.find_first_not_of(" \t", at);
        if (first == std::string::npos)
            break;
        const bool is_vector = text[first] == '(';
        const auto end = std::min(text.find_first_of(is_vector ? ")" : " \t", first), text.size());
        auto inside = is_vector ? text.substr(first + 1, end - first - 1) : std::string();
        std::ranges::replace(inside, ',', ' ');
        vectors.push_back(numbers_in(inside));
        if (!std::ranges::all_of(vectors.back(), [](double x) { return std::isfinite(x); }))
            vectors.back().clear(); // older writers say "none" so
        at = end + 1;
    }
    return vectors;
}

/// Words between quotes, or between spaces where there are none.
std::vector<std::string> words_in(const std::string &text) {
    std::vector<std::string> words;
    if (text.find('"') == std::string::npos) {
        std::istringstream stream(text);
        for (std::string word; stream >> word;)
            words.push_back(word);
        return words;
    }
    for (auto open = text.find('"'); open != std::string::npos;) {
        const auto close = text.find('"', open + 1);
        words.push_back(trimmed(text.substr(open + 1, close == std::string::npos ? close : close - open - 1)));
        open = close == std::string::npos ? close : text.find('"', close + 1);
    }
    return words;
}

/// Metres of each of three directions.
Vector3 metres_in(const Fields &fields, const std::string &key, const fs::path &file) {
    Vector3 metres = Vector3::Constant(metres_where_no_unit_is_said);
    if (const auto field = fields.find(key); field != fields.end()) {
        const auto units = words_in(field->second);
        for (std::size_t d = 0; d < std::min<std::size_t>(3, units.size()); ++d)
            metres[static_cast<Eigen::Index>(d)] = metres_per_unit_in(file, units[d]);
    }
    return metres;
}

/// Signs that turn the coordinates of a space of NRRD into LPS; nothing if the space has no anatomical meaning.
std::optional<Vector3> signs_of_space(std::string space, const fs::path &file) {
    const auto said = space;
    space = support::lower_case(space);
    std::erase_if(space, [](char c) { return c == ' ' || c == '-'; }); // of which the format has both, or neither
    if (space.ends_with("time"))
        space.resize(space.size() - 4);
    const auto is = [&](const char *name, const char *letters) {
        return space == name || space == letters || space == std::string(letters) + "t";
    };
    if (is("leftposteriorsuperior", "lps"))
        return Vector3(1.0, 1.0, 1.0);
    if (is("rightanteriorsuperior", "ras"))
        return Vector3(-1.0, -1.0, 1.0);
    if (is("leftanteriorsuperior", "las"))
        return Vector3(1.0, -1.0, 1.0);
    if (space == "3dlefthanded")
        throw InputError("{}: its header says '{}', which does not say where the patient's left is and would mirror "
                         "the body; name its axes, such as left-posterior-superior",
                         file.string(), said);
    return std::nullopt; // scanner-xyz, 3D-right-handed, or a number of dimensions
}

HeaderGrid nrrd_grid(const fs::path &file) {
    const auto fields = nrrd_fields(file);
    const auto value = [&](const char *key) {
        const auto field = fields.find(key);
        return field == fields.end() ? std::string() : field->second;
    };
    HeaderGrid grid;
    const auto sizes = numbers_in(value("sizes"));
    auto vectors = vectors_in(value("spacedirections"));
    const auto signs = signs_of_space(value("space"), file);
    std::vector<std::size_t> axes; // of the image, which others may stand before or behind
    for (std::size_t a = 0; a < vectors.size() && a < sizes.size() && axes.size() < 3; ++a)
        if (vectors[a].size() >= 3)
            axes.push_back(a);
    if (!signs || axes.size() < 3)
        grid.remarks.emplace_back(no_axes);
    if (axes.size() == 3) {
        const Vector3 metres = metres_in(fields, "spaceunits", file);
        const Vector3 to_lps = signs.value_or(Vector3::Ones()).cwiseProduct(metres);
        const auto in_lps = [&](const std::vector<double> &vector) {
            return Vector3(to_lps.cwiseProduct(Vector3(vector[0], vector[1], vector[2])));
        };
        Eigen::Matrix3d directions;
        std::array<int, 3> size{};
        for (std::size_t a = 0; a < 3; ++a) {
            directions.col(static_cast<Eigen::Index>(a)) = in_lps(vectors[axes[a]]);
            size.at(a) = extent_of(sizes[axes[a]]);
        }
        const auto origin = vectors_in(value("spaceorigin"));
        const Vector3 lengths = directions.colwise().norm();
        if (!(lengths.array() > 0.0).all() || !lengths.allFinite())
            return grid; // ITK refuses such axes
        grid.size = size;
        grid.spacing = lengths;
        Placement placement{with_columns_of_length_1(directions), std::nullopt};
        if (origin.size() == 1 && origin[0].size() >= 3)
            placement.origin = in_lps(origin[0]);
        grid.placements.push_back(placement);
    } else if (const auto spacings = numbers_in(value("spacings")); spacings.size() == 3 && sizes.size() == 3) {
        const Vector3 lengths(spacings[0], spacings[1], spacings[2]);
        if (lengths.allFinite() && (lengths.array() > 0.0).all())
            grid.spacing = lengths.cwiseProduct(metres_in(fields, "units", file));
    }
    return grid;
}

/// "Key = value", or with a colon, up to the name of the file of voxels.
Fields meta_image_fields(const fs::path &file) {
    constexpr std::size_t most_fields = 10000;
    Fields fields;
    std::ifstream stream(file, std::ios::binary);
    for (std::string line;
         fields.size() < most_fields && !fields.contains("ElementDataFile") && std::getline(stream, line);)
        if (const auto separator = line.find_first_of("=:"); separator != std::string::npos)
            fields[trimmed(line.substr(0, separator))] = trimmed(line.substr(separator + 1));
    return fields;
}

HeaderGrid meta_image_grid(const fs::path &file) {
    const auto fields = meta_image_fields(file);
    const auto numbers = [&](std::initializer_list<const char *> keys) {
        for (const char *key : keys)
            if (const auto field = fields.find(key); field != fields.end())
                return numbers_in(field->second);
        return std::vector<double>();
    };
    const auto first_three = [](const std::vector<double> &of) { return Vector3(of[0], of[1], of[2]); };
    HeaderGrid grid;
    const auto unit = fields.find("DistanceUnits");
    const double metres = unit == fields.end() ? metres_where_no_unit_is_said : metres_per_unit_in(file, unit->second);
    const auto sizes = numbers({"DimSize"});
    const auto num_dimensions = sizes.size();
    if (num_dimensions < 3)
        return grid;
    std::array<int, 3> size{};
    for (std::size_t a = 0; a < 3; ++a)
        size.at(a) = extent_of(sizes[a]);
    grid.size = size;
    if (const auto spacing = numbers({"ElementSpacing", "ElementSize"}); spacing.size() >= 3)
        if (const Vector3 lengths = first_three(spacing); lengths.allFinite() && (lengths.array() > 0.0).all())
            grid.spacing = metres * lengths;
    Placement placement;
    const auto matrix = numbers({"TransformMatrix", "Rotation", "Orientation"});
    if (matrix.size() == num_dimensions * num_dimensions)
        for (std::size_t a = 0; a < 3; ++a)
            for (std::size_t c = 0; c < 3; ++c)
                placement.direction(static_cast<Eigen::Index>(c), static_cast<Eigen::Index>(a)) =
                    matrix[num_dimensions * a + c];
    if (const auto offset = numbers({"Offset", "Position", "Origin"}); offset.size() >= 3)
        placement.origin = metres * first_three(offset);
    placement.direction = with_columns_of_length_1(placement.direction);
    if (placement.direction.allFinite())
        grid.placements.push_back(placement);
    if (const auto said = fields.find("AnatomicalOrientation");
        matrix.empty() && said != fields.end() && said->second != "RAI" && said->second.find('?') == std::string::npos)
        grid.remarks.push_back(fmt::format("its header says AnatomicalOrientation = {}, which counts for nothing "
                                           "without a TransformMatrix; the axes are taken for left, posterior and "
                                           "superior, so look at the patches",
                                           support::shown(said->second)));
    return grid;
}

} // namespace

HeaderGrid grid_in_header(const fs::path &file) {
    if (const auto header = read_nifti_header(file))
        return nifti_grid(*header, file);
    const auto ending = support::file_ending(file);
    if (ending == ".nrrd" || ending == ".nhdr")
        return nrrd_grid(file);
    if (ending == ".mha" || ending == ".mhd")
        return meta_image_grid(file);
    return {};
}

void correct_by_header(ImageGrid &grid, const HeaderGrid &header, const std::string &file,
                       std::vector<std::string> &remarks) {
    constexpr double most_off = 1e-3; // of a length; headers have six digits
    constexpr double most_degrees = 0.5;
    if (header.size && *header.size != grid.size)
        throw InputError("{}: its header says {} voxels, and {} are read; export the image again", file,
                         fmt::join(*header.size, " x "), fmt::join(grid.size, " x "));
    std::vector<std::string> corrected;
    if (header.spacing && ((*header.spacing - grid.spacing).array().abs() > most_off * header.spacing->array()).any()) {
        grid.spacing = *header.spacing;
        corrected.emplace_back("spacing");
    }
    if (!header.placements.empty()) {
        const auto &said = *std::ranges::min_element(header.placements, {}, [&](const Placement &placement) {
            return degrees_between(placement.direction, grid.direction) +
                   (placement.origin ? (*placement.origin - grid.origin).norm() : 0.0);
        });
        if (!(degrees_between(said.direction, grid.direction) <= most_degrees)) {
            grid.direction = said.direction;
            corrected.emplace_back("axes");
        }
        if (said.origin &&
            !((*said.origin - grid.origin).norm() <= most_off * (grid.spacing.minCoeff() + said.origin->norm()))) {
            grid.origin = *said.origin;
            corrected.emplace_back("origin");
        }
    }
    if (!corrected.empty())
        remarks.push_back(
            fmt::format("{} of the image {} what its header says, {:.4g} x {:.4g} x {:.4g} mm a voxel, the "
                        "first at ({:.4g}, {:.4g}, {:.4g}) mm in LPS; programs that use ITK, as 3D "
                        "Slicer, may show it elsewhere",
                        fmt::join(corrected, " and "), corrected.size() > 1 ? "are" : "is", 1e3 * grid.spacing.x(),
                        1e3 * grid.spacing.y(), 1e3 * grid.spacing.z(), 1e3 * grid.origin.x(), 1e3 * grid.origin.y(),
                        1e3 * grid.origin.z()));
}

} // namespace livermark::segmentation
