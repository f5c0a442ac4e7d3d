#include "meshes/io/mesh_files.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdint>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <unordered_map>

#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/support/toml_input.hpp"
#include "meshes/io/mesh_checks.hpp"

namespace livermark::meshes {

/// Walks through the words of an MSH file and knows in which line it stands.
class MshTokens {
  public:
    MshTokens(std::string_view text, std::string file) : text_(text), file_(std::move(file)) {}

    /// @return false at the end of the file
    bool at_word();
    std::string_view word();
    std::string quoted();
    std::int64_t integer();
    /// An integer of at least this size, that fits an int.
    int count(int smallest = 0);
    double number();
    void expect(std::string_view wanted);
    void skip_words(std::int64_t num_words);
    /// Goes on behind the next line that is this word.
    void skip_to(std::string_view wanted);

    /// @throws support::InputError "file:line: what"
    [[noreturn]] void fail(const std::string &what) const;

  private:
    std::string_view text_;
    std::string file_;
    std::size_t position_ = 0;
    int line_ = 1;
};

namespace {

bool is_space(char c) {
    return std::isspace(static_cast<unsigned char>(c)) != 0;
}

/// Reads all of a word. Some programs write a plus sign, which from_chars does not know.
template <class Number> bool is_read(std::string_view text, Number &value) {
    if (text.size() > 1 && text[0] == '+' && text[1] != '-')
        text.remove_prefix(1);
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc{} && end == text.data() + text.size();
}

} // namespace

void MshTokens::fail(const std::string &what) const {
    throw support::InputError("{}:{}: {}", file_, line_, what);
}

bool MshTokens::at_word() {
    while (position_ < text_.size() && is_space(text_[position_]))
        line_ += text_[position_++] == '\n';
    return position_ < text_.size();
}

std::string_view MshTokens::word() {
    if (!at_word())
        fail("the file ends too early; save it again");
    const auto start = position_;
    while (position_ < text_.size() && !is_space(text_[position_]))
        ++position_;
    return text_.substr(start, position_ - start);
}

std::string MshTokens::quoted() {
    if (!at_word() || text_[position_] != '"')
        fail("a name in quotes has to stand here");
    const auto end = text_.find_first_of("\"\n", position_ + 1);
    if (end == std::string_view::npos || text_[end] != '"')
        fail("a name in quotes does not end; close the quotes");
    const auto name = text_.substr(position_ + 1, end - position_ - 1);
    position_ = end + 1;
    return std::string(name);
}

std::int64_t MshTokens::integer() {
    const auto text = word();
    std::int64_t value = 0;
    if (!is_read(text, value))
        fail(fmt::format("'{}' has to be an integer", support::shown(text)));
    return value;
}

int MshTokens::count(int smallest) {
    const auto value = integer();
    if (value < smallest || value > std::numeric_limits<int>::max())
        fail(fmt::format("{} is out of range here; give a number from {} to {}", value, smallest,
                         std::numeric_limits<int>::max()));
    return static_cast<int>(value);
}

double MshTokens::number() {
    const auto text = word();
    double value = 0.0;
    if (!is_read(text, value))
        fail(fmt::format("'{}' has to be a number", support::shown(text)));
    return value;
}

void MshTokens::expect(std::string_view wanted) {
    if (const auto found = word(); found != wanted)
        fail(fmt::format("'{}' has to stand here, not '{}'", wanted, support::shown(found)));
}

void MshTokens::skip_words(std::int64_t num_words) {
    for (std::int64_t w = 0; w < num_words; ++w)
        word();
}

void MshTokens::skip_to(std::string_view wanted) {
    while (word() != wanted) {
    }
}

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

/// Physical groups that an element is in.
using Groups = std::vector<int>;

/// Whether two elements have the same nodes.
template <class Element> bool has_repeated(std::vector<Element> elements) {
    for (auto &nodes : elements)
        std::ranges::sort(nodes);
    std::ranges::sort(elements);
    return std::ranges::adjacent_find(elements) != elements.end();
}

/// Elements that are there once for each of their groups become one in all of them. The same element twice in one group
/// stays, to be refused.
template <class Element>
void merge_repeated(std::vector<Element> &elements, std::vector<Groups> &groups, std::vector<std::int64_t> *tags) {
    if (!has_repeated(elements))
        return; // as in most files, and the search below takes a while on a large one
    std::map<Element, std::size_t> seen;
    std::size_t num_kept = 0;
    for (std::size_t e = 0; e < elements.size(); ++e) {
        auto key = elements[e];
        std::ranges::sort(key);
        const auto [first, is_new] = seen.emplace(key, num_kept);
        if (auto &known = groups[first->second];
            !is_new && std::ranges::find(known, groups[e].front()) == known.end()) {
            known.push_back(groups[e].front());
            continue;
        }
        elements[num_kept] = elements[e];
        groups[num_kept] = groups[e];
        if (tags)
            (*tags)[num_kept] = (*tags)[e];
        ++num_kept;
    }
    elements.resize(num_kept);
    groups.resize(num_kept);
    if (tags)
        tags->resize(num_kept);
}

/// Group of each element. Of groups that overlap the one with fewer elements counts, say a lesion in a whole liver.
/// @param word  for a group without a name
/// @param tags  of the elements, if these are kept
template <class Element>
void choose_groups(std::vector<Element> &elements, std::vector<Groups> &groups, const std::map<int, std::string> &names,
                   const std::string &word, std::vector<int> &chosen, std::vector<std::int64_t> *tags,
                   std::vector<std::string> &remarks) {
    if (word == "region") // a triangle in two patches is for the user to decide
        merge_repeated(elements, groups, tags);
    std::map<int, std::size_t> size;
    for (const auto &own_groups : groups)
        for (const int group : own_groups)
            ++size[group];
    std::map<std::pair<int, int>, std::size_t> shared; // by the group that counts and the other
    for (const auto &own_groups : groups) {
        const int smallest = *std::ranges::min_element(own_groups, {}, [&](int group) { return size[group]; });
        chosen.push_back(smallest);
        for (const int group : own_groups)
            if (group != smallest)
                ++shared[{smallest, group}];
    }
    const auto name_of = [&](int group) {
        const auto named = names.find(group);
        return named == names.end() ? fmt::format("{}_{}", word, group) : named->second;
    };
    for (const auto &[pair, count] : shared)
        remarks.push_back(
            fmt::format("the groups '{1}' and '{0}' share {2} elements, which count as '{0}', the smaller "
                        "one",
                        name_of(pair.first), name_of(pair.second), count));
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
                if (section.ends_with("Data"))
                    unused_.insert(section.substr(1));
                tokens_.skip_to(end_of(section));
                continue;
            } else
                tokens_.fail("a section has to begin here, with a word like $Nodes; save the file again");
            tokens_.expect(end_of(section));
        }
        choose_groups(mesh_.tetrahedra, groups_of_tetrahedra_, mesh_.region_names, "region", mesh_.region_tag,
                      &mesh_.tetrahedron_tag, mesh_.remarks);
        choose_groups(mesh_.triangles, groups_of_triangles_, mesh_.patch_names, "patch", mesh_.patch_tag, nullptr,
                      mesh_.remarks);
        if (!unused_.empty())
            mesh_.remarks.push_back(fmt::format("values in the file are not used: {}", fmt::join(unused_, ", ")));
        if (!other_groups_.empty())
            mesh_.remarks.push_back(
                fmt::format("groups of lines and points are not used: {}", fmt::join(other_groups_, ", ")));
        leave_out_stray_triangles(mesh_);
        return std::move(mesh_);
    }

  private:
    /// MSH 1 has no section that says so; it begins with its nodes.
    std::string first_section() {
        auto section = next_section();
        while (section == "$Comments") {
            tokens_.skip_to("$EndComments");
            section = next_section();
        }
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
            tokens_.fail("this is not a gmsh mesh: $MeshFormat has to come first, or $NOD in MSH 1");
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
            else
                other_groups_.push_back(std::move(name));
        }
    }

    /// Physical groups of every surface and volume. Where a group is turned over its number is negative.
    void read_entities() {
        const std::array num_entities{tokens_.count(), tokens_.count(), tokens_.count(), tokens_.count()};
        for (int dimension = 0; dimension < 4; ++dimension)
            for (int e = 0; e < num_entities[static_cast<std::size_t>(dimension)]; ++e) {
                const auto tag = tokens_.integer();
                tokens_.skip_words(dimension == 0 ? 3 : 6); // the point, or the bounding box
                const int num_groups = tokens_.count();
                for (int g = 0; g < num_groups; ++g)
                    groups_of_entity_[{dimension, tag}].push_back(group_number());
                if (dimension > 0)
                    tokens_.skip_words(tokens_.count()); // what bounds it
            }
    }

    /// A physical group, turned over or not.
    int group_number() {
        const auto value = tokens_.integer();
        if (value < -std::numeric_limits<int>::max() || value > std::numeric_limits<int>::max())
            tokens_.fail(fmt::format("the group {} is out of range", value));
        return static_cast<int>(value < 0 ? -value : value);
    }

    void add_node(std::int64_t tag) {
        if (!node_of_.emplace(tag, static_cast<int>(mesh_.points.size())).second)
            tokens_.fail(fmt::format("node {} occurs twice; remove one", tag));
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

    void add_element(int type, std::int64_t tag, const Groups &groups) {
        if (type == triangle_type) {
            mesh_.triangles.push_back({node(), node(), node()});
            groups_of_triangles_.push_back(groups);
        } else if (type == tetrahedron_type) {
            mesh_.tetrahedra.push_back({node(), node(), node(), node()});
            mesh_.tetrahedron_tag.push_back(tag);
            groups_of_tetrahedra_.push_back(groups);
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
            const int group = num_tags > 0 ? group_number() : 0;
            for (int t = 1; t < num_tags; ++t)
                tokens_.integer();
            add_element(type, tag, {group});
        }
    }

    /// Number, type, physical and elementary group, number of nodes, nodes.
    void read_elements_1() {
        for (int n = tokens_.count(); n > 0; --n) {
            const auto tag = tokens_.integer();
            const int type = tokens_.count();
            const int group = group_number();
            tokens_.integer();
            const int num_nodes = tokens_.count();
            const int wanted = type == triangle_type ? 3 : type == tetrahedron_type ? 4 : nodes_to_skip(type);
            if (wanted > 0 && num_nodes != wanted)
                tokens_.fail(fmt::format("element {} has {} nodes where its type {} has {}; correct it", tag, num_nodes,
                                         type, wanted));
            add_element(type, tag, {group});
        }
    }

    void read_elements_4() {
        const int num_blocks = tokens_.count();
        tokens_.skip_words(3); // number of elements, smallest and largest tag
        for (int b = 0; b < num_blocks; ++b) {
            const int dimension = tokens_.count();
            const auto entity = tokens_.integer();
            const int type = tokens_.count();
            const auto grouped = groups_of_entity_.find({dimension, entity});
            const auto groups = grouped == groups_of_entity_.end() ? Groups{0} : grouped->second;
            for (int n = tokens_.count(); n > 0; --n)
                add_element(type, tokens_.integer(), groups);
        }
    }

    MshTokens tokens_;
    std::string end_of(const std::string &section) const {
        return (is_version_1_ ? "$END" : "$End") + section.substr(1);
    }

    bool is_version_1_ = false;
    bool is_version_4_ = false;
    RawMesh mesh_;
    std::vector<Groups> groups_of_tetrahedra_, groups_of_triangles_;
    std::map<std::pair<int, std::int64_t>, Groups> groups_of_entity_; // by dimension and entity
    std::unordered_map<std::int64_t, int> node_of_;                   // tag -> index
    std::set<std::string> unused_;                                    // sections with values of nodes and elements
    std::vector<std::string> other_groups_;                           // names of groups of lines and points
};

} // namespace

core::TetraMesh parse_msh(const std::string &text, const std::string &file, std::vector<std::string> *remarks) {
    const auto raw = MshParser(text, file).parse();
    if (remarks)
        remarks->insert(remarks->end(), raw.remarks.begin(), raw.remarks.end());
    return assemble_mesh(raw, file);
}

core::TetraMesh read_msh(const std::filesystem::path &file, std::vector<std::string> *remarks) {
    return parse_msh(support::read_text(file), file.string(), remarks);
}

} // namespace livermark::meshes
