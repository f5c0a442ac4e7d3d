#include "meshes/msh_reader.hpp"

#include <fmt/format.h>
#include <unordered_map>

#include "meshes/msh_tokens.hpp"
#include "meshes/raw_mesh.hpp"
#include "support/input_error.hpp"
#include "support/toml_input.hpp"
#include "support/whole_file.hpp"

namespace livermark::meshes {

namespace {

/// Element types of the format that matter here; https://gmsh.info/doc/texinfo/gmsh.html#MSH-file-format
constexpr int triangle_type = 2;
constexpr int tetrahedron_type = 4;

/// Number of nodes of the element types that are passed over (points, lines), 0 for what cannot be used.
int nodes_to_skip(int type) {
    switch (type) {
    case 1:
        return 2;
    case 15:
        return 1;
    default:
        return 0;
    }
}

class MshParser {
  public:
    MshParser(std::string_view text, const std::string &file) : tokens_(text, file) {}

    RawMesh parse() {
        auto section = first_section();
        for (; !section.empty(); section = next_section()) {
            if (section == "$PhysicalNames")
                read_physical_names();
            else if (section == "$Entities" && is_version_4_)
                read_entities();
            else if (section == "$PartitionedEntities")
                tokens_.fail("the mesh is partitioned; save it in one part");
            else if (section == "$Nodes")
                is_version_4_ ? read_nodes_4() : read_nodes_2();
            else if (section == "$Elements")
                is_version_4_ ? read_elements_4() : read_elements_2();
            else if (section == "$NOD" && is_version_1_)
                read_nodes_2();
            else if (section == "$ELM" && is_version_1_)
                read_elements_1();
            else if (section.size() > 1 && section.front() == '$') {
                tokens_.skip_to(end_of(section));
                continue;
            } else
                tokens_.fail("a section has to begin here, with a word like $Nodes; save the file again");
            tokens_.expect(end_of(section));
        }
        return std::move(mesh_);
    }

  private:
    /// MSH 1 has no section that says so; it begins with its nodes.
    std::string first_section() {
        auto section = next_section();
        is_version_1_ = section == "$NOD";
        if (is_version_1_)
            return section;
        read_format(section);
        return next_section();
    }

    /// @return empty at the end of the file
    std::string next_section() { return tokens_.at_word() ? std::string(tokens_.word()) : std::string(); }

    void read_format(const std::string &section) {
        if (section != "$MeshFormat")
            tokens_.fail("this is no gmsh mesh: $MeshFormat has to come first, or $NOD in MSH 1");
        const auto version = tokens_.word();
        if (version != "2.2" && version != "4.1")
            tokens_.fail("only MSH 1, 2.2 and 4.1 can be read; save it with: gmsh -save -format msh41 FILE");
        is_version_4_ = version == "4.1";
        if (tokens_.integer() != 0)
            tokens_.fail("the file is binary; save it as ASCII with: gmsh -save -format msh41 FILE");
        tokens_.integer();
        tokens_.expect("$EndMeshFormat");
    }

    void read_physical_names() {
        for (int n = tokens_.count(); n > 0; --n) {
            const auto dimension = tokens_.integer();
            const int tag = tokens_.count(1);
            auto name = tokens_.quoted();
            if (name.empty())
                tokens_.fail("a region or patch has an empty name; name it");
            if (dimension == 3)
                mesh_.region_names[tag] = std::move(name);
            else if (dimension == 2)
                mesh_.patch_names[tag] = std::move(name);
        }
    }

    /// Keeps the first physical group of every surface and volume.
    void read_entities() {
        const std::array num_entities{tokens_.count(), tokens_.count(), tokens_.count(), tokens_.count()};
        for (int dimension = 0; dimension < 4; ++dimension)
            for (int e = 0; e < num_entities[static_cast<std::size_t>(dimension)]; ++e) {
                const auto tag = tokens_.integer();
                tokens_.skip_words(dimension == 0 ? 3 : 6); // the point, or the bounding box
                const int num_groups = tokens_.count();
                for (int g = 0; g < num_groups; ++g)
                    if (const auto group = tokens_.count(1); g == 0)
                        group_of_[{dimension, tag}] = group;
                if (dimension > 0)
                    tokens_.skip_words(tokens_.count()); // what bounds it
            }
    }

    void add_node(std::int64_t tag) {
        if (!node_of_.emplace(tag, static_cast<int>(mesh_.points.size())).second)
            tokens_.fail(fmt::format("node {} is there twice; remove one", tag));
        mesh_.node_tag.push_back(tag);
        const double x = tokens_.number();
        const double y = tokens_.number();
        const double z = tokens_.number();
        mesh_.points.emplace_back(x, y, z);
    }

    void read_nodes_2() {
        for (int n = tokens_.count(); n > 0; --n)
            add_node(tokens_.integer());
    }

    void read_nodes_4() {
        const int num_blocks = tokens_.count();
        tokens_.skip_words(3); // number of nodes, smallest and largest tag
        for (int b = 0; b < num_blocks; ++b) {
            const auto dimension = tokens_.integer();
            tokens_.integer(); // entity
            const bool is_parametric = tokens_.integer() != 0;
            const int num_nodes = tokens_.count();
            std::vector<std::int64_t> tags;
            for (int n = 0; n < num_nodes; ++n)
                tags.push_back(tokens_.integer());
            for (const auto tag : tags) {
                add_node(tag);
                if (is_parametric)
                    tokens_.skip_words(dimension);
            }
        }
    }

    int node() {
        const auto tag = tokens_.integer();
        const auto found = node_of_.find(tag);
        if (found == node_of_.end())
            tokens_.fail(fmt::format("there is no node {}; correct the element", tag));
        return found->second;
    }

    void add_element(int type, std::int64_t tag, int group) {
        if (type == triangle_type) {
            mesh_.triangles.push_back({node(), node(), node()});
            mesh_.patch_tag.push_back(group);
        } else if (type == tetrahedron_type) {
            mesh_.tetrahedra.push_back({node(), node(), node(), node()});
            mesh_.tetrahedron_tag.push_back(tag);
            mesh_.region_tag.push_back(group);
        } else if (nodes_to_skip(type) > 0)
            tokens_.skip_words(nodes_to_skip(type));
        else
            tokens_.fail(fmt::format("element {} is of type {}; only linear triangles and tetrahedra can be used, so "
                                     "mesh without recombination and with order 1",
                                     tag, type));
    }

    void read_elements_2() {
        for (int n = tokens_.count(); n > 0; --n) {
            const auto tag = tokens_.integer();
            const int type = tokens_.count();
            const int num_tags = tokens_.count();
            int group = 0;
            for (int t = 0; t < num_tags; ++t)
                if (const auto value = tokens_.count(); t == 0)
                    group = value;
            add_element(type, tag, group);
        }
    }

    /// Number, type, physical and elementary group, number of nodes, nodes.
    void read_elements_1() {
        for (int n = tokens_.count(); n > 0; --n) {
            const auto tag = tokens_.integer();
            const int type = tokens_.count();
            const int group = tokens_.count();
            tokens_.count();
            const int num_nodes = tokens_.count();
            const int wanted = type == triangle_type ? 3 : type == tetrahedron_type ? 4 : nodes_to_skip(type);
            if (wanted > 0 && num_nodes != wanted)
                tokens_.fail(fmt::format("element {} has {} nodes where its type {} has {}; correct it", tag, num_nodes,
                                         type, wanted));
            add_element(type, tag, group);
        }
    }

    void read_elements_4() {
        const int num_blocks = tokens_.count();
        tokens_.skip_words(3); // number of elements, smallest and largest tag
        for (int b = 0; b < num_blocks; ++b) {
            const int dimension = tokens_.count();
            const auto entity = tokens_.integer();
            const int type = tokens_.count();
            const auto grouped = group_of_.find({dimension, entity});
            const int group = grouped == group_of_.end() ? 0 : grouped->second;
            for (int n = tokens_.count(); n > 0; --n)
                add_element(type, tokens_.integer(), group);
        }
    }

    MshTokens tokens_;
    std::string end_of(const std::string &section) const {
        return (is_version_1_ ? "$END" : "$End") + section.substr(1);
    }

    bool is_version_1_ = false;
    bool is_version_4_ = false;
    RawMesh mesh_;
    std::map<std::pair<int, std::int64_t>, int> group_of_; // (dimension, entity) -> physical group
    std::unordered_map<std::int64_t, int> node_of_;        // tag -> index
};

} // namespace

core::TetraMesh parse_msh(const std::string &text, const std::string &file) {
    return assemble_mesh(MshParser(text, file).parse(), file);
}

core::TetraMesh read_msh(const std::filesystem::path &file) {
    return parse_msh(support::read_text(file), file.string());
}

} // namespace livermark::meshes
