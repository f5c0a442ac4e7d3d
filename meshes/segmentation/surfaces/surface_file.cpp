#include "meshes/segmentation/surfaces/surface_file.hpp"

#include <CGAL/IO/OBJ.h>
#include <CGAL/IO/OFF.h>
#include <CGAL/IO/PLY.h>
#include <CGAL/IO/STL.h>
#include <CGAL/IO/polygon_soup_io.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <string_view>
#include <utility>

#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/support/processes/child_process.hpp"
#include "core/support/processes/own_process.hpp"
#include "meshes/io/mesh_files.hpp"
#include "meshes/segmentation/surfaces/surface_repair.hpp"

namespace livermark::segmentation {

namespace {

/// Whether an STL file is text with keywords that are not in lower case. Binary files may begin with the same word.
bool has_capitals(const std::string &text) {
    constexpr std::string_view first = "solid", second = "facet";
    constexpr std::size_t looked_at = 1000;
    const auto begin = text.find_first_not_of(" \t\r\n");
    if (begin == std::string::npos || support::lower_case(text.substr(begin, first.size())) != first)
        return false;
    const auto head = text.substr(begin, looked_at);
    return head.find('\0') == std::string::npos && head.find(second) == std::string::npos &&
           support::lower_case(head).find(second) != std::string::npos;
}

/// Without lines ("l 1 2") and points ("p 1").
std::string only_faces(const std::string &text, std::size_t &num_left_out) {
    std::string faces;
    for (std::size_t begin = 0; begin < text.size();) {
        const auto end = text.find('\n', begin);
        const auto next = end == std::string::npos ? text.size() : end + 1;
        const auto word = text.find_first_not_of(" \t", begin);
        const bool is_other = word != std::string::npos && word + 1 < next &&
                              (text[word] == 'l' || text[word] == 'p') &&
                              (text[word + 1] == ' ' || text[word + 1] == '\t');
        if (is_other)
            ++num_left_out;
        else
            faces.append(text, begin, next - begin);
        begin = next;
    }
    return faces;
}

} // namespace

PlainSurfaceText plain_surface_text(std::string text, const std::string &ending) {
    constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";
    PlainSurfaceText plain;
    if (text.starts_with(byte_order_mark)) {
        text.erase(0, byte_order_mark.size());
        plain.text = text;
    }
    if (ending == ".stl" && has_capitals(text))
        plain.text = support::lower_case(text);
    if (ending == ".obj")
        if (auto faces = only_faces(text, plain.num_left_out); plain.num_left_out > 0)
            plain.text = std::move(faces);
    return plain;
}

namespace {

namespace fs = std::filesystem;
using support::InputError;

constexpr const char *formats = "STL, OBJ, PLY, OFF, VTK or VTP";

/// MSH 1, which meshio does not know.
bool is_first_msh(const fs::path &file) {
    return support::file_ending(file) == ".msh" && meshes::first_bytes(file).starts_with("$NOD");
}

TriangleSoup boundary_of(const fs::path &file, std::vector<std::string> &remarks) {
    const auto mesh = meshes::read_mesh(file, remarks);
    remarks.push_back(fmt::format("{}: the boundary of its tetrahedra is taken", file.string()));
    TriangleSoup soup;
    for (const auto &p : mesh.points)
        soup.points.emplace_back(p.x(), p.y(), p.z());
    for (const auto &[a, b, c] : mesh.boundary_triangles)
        soup.triangles.push_back(
            {static_cast<std::size_t>(a), static_cast<std::size_t>(b), static_cast<std::size_t>(c)});
    return soup;
}

/// Polygons become the triangles that their first corner has with the others.
void cut_polygons(TriangleSoup &soup, const std::string &file, std::vector<std::string> &remarks) {
    std::vector<std::vector<std::size_t>> triangles;
    std::size_t num_cut = 0;
    for (const auto &polygon : soup.triangles) {
        num_cut += polygon.size() > 3 ? 1 : 0;
        for (std::size_t k = 1; k + 1 < polygon.size(); ++k)
            triangles.push_back({polygon[0], polygon[k], polygon[k + 1]});
    }
    if (num_cut > 0)
        remarks.push_back(fmt::format("{}: {} polygons are cut into triangles", file, num_cut));
    soup.triangles = std::move(triangles);
}

/// All of it, with a byte order mark if it has one.
std::string bytes_of(const fs::path &file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

bool read_soup_of_text(const std::string &ending, const std::string &text, TriangleSoup &soup) {
    std::istringstream stream(text);
    if (ending == ".stl")
        return CGAL::IO::read_STL(stream, soup.points, soup.triangles);
    if (ending == ".obj")
        return CGAL::IO::read_OBJ(stream, soup.points, soup.triangles);
    if (ending == ".ply")
        return CGAL::IO::read_PLY(stream, soup.points, soup.triangles);
    return CGAL::IO::read_OFF(stream, soup.points, soup.triangles);
}

TriangleSoup read_plain(const fs::path &file, std::vector<std::string> &remarks) {
    TriangleSoup soup;
    const auto ending = support::file_ending(file);
    const auto plain = plain_surface_text(bytes_of(file), ending);
    if (plain.num_left_out > 0)
        remarks.push_back(
            fmt::format("{}: {} lines and points beside its faces are not used", file.string(), plain.num_left_out));
    const bool is_read = plain.text ? read_soup_of_text(ending, *plain.text, soup)
                                    : CGAL::IO::read_polygon_soup(file.string(), soup.points, soup.triangles);
    if (!is_read || soup.triangles.empty())
        throw InputError("{}: no triangles can be read from it; export the surface as {}", file.string(), formats);
    cut_polygons(soup, file.string(), remarks);
    return soup;
}

/// Format to which a file of another format is converted; nothing if it is read as it is.
std::optional<support::Converted> converted_if_needed(const fs::path &file) {
    if (is_first_msh(file) || meshes::has_surface_ending(file))
        return std::nullopt;
    auto converted = support::convert_by_script(
        "convert_surface", file,
        fmt::format("export the surface as {}, and check that python3-meshio is installed", formats));
    for (auto &remark : converted.remarks)
        remark = fmt::format("{}: {}", file.string(), remark);
    return converted;
}

TriangleSoup read_converted(const fs::path &file, const support::Converted &converted,
                            std::vector<std::string> &remarks) {
    remarks.insert(remarks.end(), converted.remarks.begin(), converted.remarks.end());
    std::istringstream text(converted.text);
    TriangleSoup soup;
    if (!CGAL::IO::read_OFF(text, soup.points, soup.triangles) || soup.triangles.empty())
        throw InputError("{}: no triangles can be read from it; export the surface as {}", file.string(), formats);
    return soup;
}

TriangleSoup read_soup(const fs::path &file, const std::optional<support::Converted> &converted,
                       std::vector<std::string> &remarks) {
    if (converted)
        return read_converted(file, *converted, remarks);
    return meshes::has_surface_ending(file) ? read_plain(file, remarks) : boundary_of(file, remarks);
}

/// Programs write which axes they mean into the first lines, or into field data, which the conversion tells.
void turn_to_lps(TriangleSoup &soup, const fs::path &file, std::vector<std::string> &remarks) {
    const auto of_field_data = fmt::format("{}: SPACE=RAS", file.string());
    const bool is_in_field_data = std::erase(remarks, of_field_data) > 0;
    if (!is_in_field_data && meshes::first_bytes(file).find("SPACE=RAS") == std::string::npos)
        return;
    for (auto &p : soup.points)
        p = Point(-p.x(), -p.y(), p.z());
    remarks.push_back(fmt::format("{}: it says that it is in RAS, and is turned to LPS", file.string()));
}

meshes::SurfaceMesh united(const std::vector<CgalSurface> &parts) {
    meshes::SurfaceMesh mesh;
    for (const auto &part : parts) {
        std::vector<int> number(part.num_vertices());
        for (const auto v : part.vertices()) {
            number[v.idx()] = static_cast<int>(mesh.points.size());
            const auto &p = part.point(v);
            mesh.points.emplace_back(p.x(), p.y(), p.z());
        }
        for (const auto f : part.faces()) {
            std::array<int, 3> triangle{};
            std::size_t corner = 0;
            for (const auto v : vertices_around_face(part.halfedge(f), part))
                triangle.at(corner++) = number[v.idx()];
            mesh.triangles.push_back(triangle);
        }
    }
    return mesh;
}

/// All that is needed of the other process.
struct ReadSurfaces {
    std::vector<meshes::SurfaceMesh> surfaces;
    std::vector<std::string> remarks;
};

std::string packed(const ReadSurfaces &read) {
    support::Packer packer;
    packer.put(read.remarks);
    packer.put(static_cast<int>(read.surfaces.size()));
    for (const auto &surface : read.surfaces) {
        std::vector<std::array<double, 3>> points;
        for (const auto &p : surface.points)
            points.push_back({p.x(), p.y(), p.z()});
        packer.put(points);
        packer.put(surface.triangles);
    }
    return std::move(packer).bytes();
}

ReadSurfaces unpacked_surfaces(const std::string &bytes) {
    support::Unpacker unpacker(bytes);
    ReadSurfaces read;
    unpacker.get(read.remarks);
    int num_surfaces = 0;
    unpacker.get(num_surfaces);
    for (int s = 0; s < num_surfaces; ++s) {
        auto &surface = read.surfaces.emplace_back();
        std::vector<std::array<double, 3>> points;
        unpacker.get(points);
        for (const auto &[x, y, z] : points)
            surface.points.emplace_back(x, y, z);
        unpacker.get(surface.triangles);
    }
    return read;
}

ReadSurfaces read_surfaces_here(const fs::path &file, const std::optional<support::Converted> &converted,
                                bool are_lesions) {
    ReadSurfaces read;
    auto soup = read_soup(file, converted, read.remarks);
    for (const auto &p : soup.points)
        if (!std::isfinite(p.x()) || !std::isfinite(p.y()) || !std::isfinite(p.z()))
            throw InputError("{}: a coordinate is not a finite number; export the surface again", file.string());
    for (const auto &triangle : soup.triangles)
        for (const auto corner : triangle)
            if (corner >= soup.points.size())
                throw InputError("{}: a triangle names corner {} of {}; export the surface again", file.string(),
                                 corner, soup.points.size());
    turn_to_lps(soup, file, read.remarks);
    if (!are_lesions) {
        read.surfaces.push_back(united(closed_parts(std::move(soup), file.string(), read.remarks)));
        return read;
    }
    for (const auto &body : closed_bodies(std::move(soup), file.string(), read.remarks))
        read.surfaces.push_back(united(body));
    return read;
}

std::vector<meshes::SurfaceMesh> read_apart(const fs::path &file, bool are_lesions, std::vector<std::string> &remarks) {
    std::error_code error;
    if (!fs::exists(file, error))
        throw InputError("{}: there is no such file; check the path", file.string());
    support::check_readable(file);
    const auto converted = converted_if_needed(file);
    constexpr double bytes_per_byte = 2000.0; // exact numbers where triangles cut each other
    auto read = unpacked_surfaces(support::in_own_process(file, support::limits_for(file, bytes_per_byte), [&] {
        return packed(read_surfaces_here(file, converted, are_lesions));
    }));
    remarks.insert(remarks.end(), read.remarks.begin(), read.remarks.end());
    return std::move(read.surfaces);
}

} // namespace

meshes::SurfaceMesh read_surface(const fs::path &file, std::vector<std::string> &remarks) {
    return read_apart(file, false, remarks).front();
}

std::vector<meshes::SurfaceMesh> read_lesions(const fs::path &file, std::vector<std::string> &remarks) {
    return read_apart(file, true, remarks);
}

} // namespace livermark::segmentation
