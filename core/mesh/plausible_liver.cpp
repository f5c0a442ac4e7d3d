#include "core/mesh/plausible_liver.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <fmt/format.h>
#include <numeric>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "core/support/files.hpp"

namespace livermark::core {

namespace {

using Words = std::span<const std::string_view>;

template <class... Word> constexpr std::array<std::string_view, sizeof...(Word)> word_list(Word... words) {
    return {words...};
}

/// Codes of SNOMED CT and of SNOMED RT, as PS3.16 has them for segments (CID 7159, 12114 and others). Codes that are
/// not here are judged by the words beside them.
struct CodedRole {
    std::string_view code;
    SegmentRole role;
};
constexpr std::array concepts{
    CodedRole{"10200004", SegmentRole::liver},   // Liver
    CodedRole{"T-62000", SegmentRole::liver},    //
    CodedRole{"108369006", SegmentRole::lesion}, // Neoplasm
    CodedRole{"86049000", SegmentRole::lesion},  // Neoplasm, Primary
    CodedRole{"372087000", SegmentRole::lesion}, // Neoplasm, Primary, in later editions
    CodedRole{"14799000", SegmentRole::lesion},  // Neoplasm, Secondary
    CodedRole{"2099007", SegmentRole::lesion},   // Hemangioma
    CodedRole{"367643001", SegmentRole::cyst},   // Cyst
    CodedRole{"M-3340A", SegmentRole::cyst},     //
    CodedRole{"52988006", SegmentRole::lesion},  // Lesion
    CodedRole{"M-01100", SegmentRole::lesion},   //
    CodedRole{"4147007", SegmentRole::lesion},   // Mass
    CodedRole{"M-03000", SegmentRole::lesion},   //
    CodedRole{"27925004", SegmentRole::lesion},  // Nodule
    CodedRole{"6574001", SegmentRole::lesion},   // Necrosis
    CodedRole{"M-54000", SegmentRole::lesion},   //
    CodedRole{"44132006", SegmentRole::lesion},  // Abscess
    CodedRole{"M-41610", SegmentRole::lesion},   //
    CodedRole{"59820001", SegmentRole::vessel},  // Blood vessel
    CodedRole{"T-40000", SegmentRole::vessel},   //
    CodedRole{"51114001", SegmentRole::vessel},  // Artery
    CodedRole{"T-41000", SegmentRole::vessel},   //
    CodedRole{"29092000", SegmentRole::vessel},  // Vein
    CodedRole{"T-48000", SegmentRole::vessel},   //
    CodedRole{"32764006", SegmentRole::vessel},  // Portal vein
    CodedRole{"T-48810", SegmentRole::vessel},   //
    CodedRole{"8993003", SegmentRole::vessel},   // Hepatic vein
    CodedRole{"T-48720", SegmentRole::vessel},   //
    CodedRole{"76015000", SegmentRole::vessel},  // Hepatic artery
    CodedRole{"64131007", SegmentRole::vessel},  // Inferior vena cava
    CodedRole{"28273000", SegmentRole::vessel},  // Bile duct
    CodedRole{"28231008", SegmentRole::gallbladder}, CodedRole{"T-63000", SegmentRole::gallbladder},
};

/// Words for the organ and its tissue, of which a name of the liver has one.
constexpr auto liver_words = word_list("liver", "livers", "hepatic", "hepar", "parenchyma", "couinaud", "leber", "foie",
                                       "h\xc3\xad"
                                       "gado",
                                       "higado", "fegato", "figado",
                                       "f\xc3\xad"
                                       "gado");
/// Words that such a name may have beside it.
constexpr auto liver_qualifiers = word_list(
    "whole", "entire", "total", "full", "complete", "all", "native", "healthy", "normal", "remaining", "remnant",
    "residual", "future", "flr", "fatty", "steatotic", "cirrhotic", "tissue", "organ", "parenchymal", "lobe", "lobes",
    "right", "left", "caudate", "quadrate", "segment", "segments", "seg", "section", "sector", "anterior", "posterior",
    "medial", "lateral", "superior", "inferior", "upper", "lower", "middle", "central", "half", "part", "parts", "of",
    "the", "mask", "label", "labels", "region", "volume", "roi", "contour", "model", "segmentation", "ct", "mr", "mri",
    "auto", "manual", "final", "edited", "smoothed", "copy", "gt", "ground", "truth", "prediction", "a", "b", "c", "s",
    "iva", "ivb", "l", "r");
constexpr auto roman_numbers = word_list("i", "ii", "iii", "iv", "v", "vi", "vii", "viii");

/// Parts of words, because some names are written without spaces: "livertumor01", "portalvein", "venacava".
constexpr auto lesion_parts =
    word_list("tumor", "tumour", "tumeur", "lesion", "lesi\xc3\xb3n", "l\xc3\xa4sion", "metast", "cancer", "carcin",
              "neoplas", "angioma", "adenom", "sarcom", "blastom", "lymphom", "malignan", "hyperplas", "nodul",
              "absces", "necros", "livermass");
constexpr auto lesion_words = word_list("mass", "masses", "hcc", "icc", "ccc", "fnh", "hca", "crlm", "gtv");
constexpr auto cyst_parts = word_list("livercyst", "kyst", "echinococ");
constexpr auto cyst_words = word_list("cyst", "cysts", "hydatid", "zyste", "zysten");
constexpr auto gallbladder_words = word_list("gallbladder", "gallenblase");
constexpr auto vessel_parts =
    word_list("vessel", "vein", "venous", "vena", "cava", "arter", "aort", "portal", "vascul", "biliar", "choledoch",
              "ductus", "thromb", "gef\xc3\xa4\xc3\x9f", "vaiss", "shunt");
constexpr auto vessel_words = word_list("duct", "ducts", "bile", "porta", "ivc", "svc", "pv", "hv", "tips");
/// Parts and words of names of vessels that lie beside the liver.
constexpr auto great_vessel_parts = word_list("cava", "aort", "coeliac", "celiac", "mesenter", "iliac");
constexpr auto great_vessel_words = word_list("ivc", "svc");
/// Organs whose lesions are not the liver's, unless the liver is named as well.
constexpr auto other_organs = word_list(
    "kidney", "kidneys", "renal", "lung", "lungs", "pulmonary", "pancreas", "pancreatic", "spleen", "splenic", "colon",
    "rectal", "rectum", "stomach", "gastric", "bladder", "brain", "breast", "bone", "prostate", "adrenal", "thyroid",
    "ovary", "ovarian", "uterus", "duodenum", "gallbladder", "esophagus", "lymph", "skin");
/// Words that turn the meaning of a lesion's name.
constexpr auto not_of_a_lesion = word_list("non", "not", "no", "bed", "margin", "margins", "healthy", "normal", "free",
                                           "ablation", "ablated", "cavity", "background", "surrounding");
/// Words behind one of these say more about what stands before it: "liver without tumours", "tumour in liver".
constexpr auto prepositions = word_list("of", "in", "within", "inside", "near", "at", "with", "without", "and",
                                        "including", "incl", "excluding", "excl", "minus", "plus", "from", "around");
/// Names that programs give by themselves.
constexpr auto words_that_say_nothing =
    word_list("segment", "segments", "seg", "segmentation", "label", "labels", "value", "region", "roi", "mask",
              "class", "object", "structure", "unknown", "unnamed", "untitled", "new", "color", "colour", "layer",
              "component", "foreground", "tissue", "organ", "anatomical");

bool is_one_of(std::string_view word, Words words) {
    return std::ranges::find(words, word) != words.end();
}

bool has_a_part(std::string_view word, Words parts) {
    return std::ranges::any_of(parts, [&](std::string_view part) { return word.find(part) != std::string_view::npos; });
}

/// Words in lower case, without numbers: a name is parted at signs, before capitals and around digits.
std::vector<std::string> words_of(const std::string &name) {
    enum class Kind { none, lower, upper, digit };
    const auto kind_of = [](unsigned char c) {
        if (std::isdigit(c))
            return Kind::digit;
        if (std::isupper(c))
            return Kind::upper;
        return std::islower(c) || c >= 0x80 ? Kind::lower : Kind::none; // of UTF-8 every byte belongs to a letter
    };
    std::vector<std::string> words;
    std::string word;
    auto before = Kind::none;
    const auto end_word = [&] {
        if (!word.empty() && before != Kind::digit)
            words.push_back(support::lower_case(word));
        word.clear();
    };
    for (const char c : name) {
        const auto kind = kind_of(static_cast<unsigned char>(c));
        const bool goes_on = kind == before || (before == Kind::upper && kind == Kind::lower);
        if (!goes_on)
            end_word();
        if (kind != Kind::none)
            word += c;
        before = kind;
    }
    end_word();
    return words;
}

bool is_liver(const std::vector<std::string> &words) {
    const auto is_of_liver = [](const std::string &word) { return is_one_of(word, liver_words); };
    return std::ranges::any_of(words, is_of_liver) && std::ranges::all_of(words, [&](const std::string &word) {
               return is_of_liver(word) || is_one_of(word, liver_qualifiers) || is_one_of(word, roman_numbers);
           });
}

bool is_there(const std::string &word) {
    return !word.starts_with("non") && !word.starts_with("peri") &&
           word.find("ectom") == std::string::npos; // what was cut out
}

bool is_of_lesion(const std::string &word) {
    return (has_a_part(word, lesion_parts) || is_one_of(word, lesion_words)) && is_there(word);
}

bool is_of_cyst(const std::string &word) {
    return (has_a_part(word, cyst_parts) || is_one_of(word, cyst_words)) && is_there(word);
}

bool is_of_vessel(const std::string &word) {
    return has_a_part(word, vessel_parts) || is_one_of(word, vessel_words);
}

bool is_of_other_organ(const std::vector<std::string> &words) {
    const auto has = [&](Words of) {
        return std::ranges::any_of(words, [&](const std::string &word) { return is_one_of(word, of); });
    };
    return has(other_organs) && !has(liver_words);
}

bool is_of_gallbladder(const std::vector<std::string> &words) {
    const auto says = [&](std::string_view word) { return std::ranges::find(words, word) != words.end(); };
    return (std::ranges::any_of(words, [](const std::string &word) { return is_one_of(word, gallbladder_words); }) ||
            (says("gall") && says("bladder"))) &&
           std::ranges::none_of(words, [](const std::string &word) { return is_one_of(word, not_of_a_lesion); });
}

/// The last word that says something decides: "tumour vessels" are vessels, a "vascular lesion" is a lesion.
SegmentRole role_of_phrase(const std::vector<std::string> &words, const std::vector<std::string> &all) {
    if (is_liver(words))
        return SegmentRole::liver;
    for (auto word = words.rbegin(); word != words.rend(); ++word) {
        if (is_of_vessel(*word))
            return SegmentRole::vessel;
        if (!is_of_lesion(*word) && !is_of_cyst(*word))
            continue;
        const bool is_turned =
            std::ranges::any_of(words, [](const std::string &w) { return is_one_of(w, not_of_a_lesion); });
        if (is_turned || is_of_other_organ(all))
            return SegmentRole::other;
        return is_of_lesion(*word) ? SegmentRole::lesion : SegmentRole::cyst;
    }
    return is_of_gallbladder(words) ? SegmentRole::gallbladder : SegmentRole::other;
}

VesselKind kind_of_words(const std::vector<std::string> &words) {
    const auto has_part = [&](Words parts) {
        return std::ranges::any_of(words, [&](const std::string &word) { return has_a_part(word, parts); });
    };
    const auto has = [&](Words of) {
        return std::ranges::any_of(words, [&](const std::string &word) { return is_one_of(word, of); });
    };
    if (has_part(word_list("portal")) || has(word_list("porta", "pv")))
        return VesselKind::portal;
    if (has_part(great_vessel_parts) || has(great_vessel_words) || is_of_other_organ(words))
        return VesselKind::beside;
    if (has_part(word_list("arter")))
        return VesselKind::artery;
    const bool is_vein = has_part(word_list("vein", "venous", "vena"));
    if ((is_vein && has(word_list("hepatic", "hepaticae"))) || has(word_list("hv")) ||
        has_part(word_list("hepaticvein")))
        return VesselKind::hepatic;
    return VesselKind::any;
}

} // namespace

SegmentRole role_of_name(const std::string &name) {
    const auto words = words_of(name);
    const auto says_nothing = [](const std::string &word) {
        return word.size() == 1 || is_one_of(word, words_that_say_nothing);
    };
    if (std::ranges::all_of(words, says_nothing))
        return SegmentRole::unnamed;
    if (is_liver(words))
        return SegmentRole::liver;
    const auto preposition =
        std::ranges::find_if(words, [](const std::string &word) { return is_one_of(word, prepositions); });
    const auto origin = std::ranges::find(words, "from"); // of a metastasis, which need not lie there
    return role_of_phrase({words.begin(), preposition}, {words.begin(), origin});
}

SegmentRole role_of_segment(const std::string &name, const SegmentCode &code) {
    const auto known = std::ranges::find(concepts, code.type, &CodedRole::code);
    auto role = SegmentRole::unnamed;
    if (known != concepts.end())
        role = known->role;
    else if (code.type.starts_with("M-8") || code.type.starts_with("M-9"))
        role = SegmentRole::lesion; // numbers of ICD-O's morphology, which are neoplasms
    else
        role = role_of_name(code.meaning);
    if (role == SegmentRole::other || role == SegmentRole::unnamed) {
        const auto by_name = role_of_name(name);
        role = by_name == SegmentRole::unnamed ? role : by_name;
    }
    const bool is_lesion = role == SegmentRole::lesion || role == SegmentRole::cyst;
    return is_lesion && is_of_other_organ(words_of(code.region)) ? SegmentRole::other : role;
}

VesselKind kind_of_vessel(const std::string &name, const SegmentCode &code) {
    const auto by_code = kind_of_words(words_of(code.meaning));
    return by_code == VesselKind::any ? kind_of_words(words_of(name)) : by_code;
}

namespace {

/// Volumes of all tetrahedra, and of each region with the name of a tumour or a cyst [m^3].
struct LiverVolumes {
    double all = 0.0;
    std::vector<double> lesions;
};

LiverVolumes liver_volumes(const TetraMesh &mesh) {
    const auto volumes = tetrahedron_volumes(mesh);
    std::vector<double> region_volume(mesh.region_names.size(), 0.0);
    for (std::size_t t = 0; t < volumes.size(); ++t)
        region_volume[static_cast<std::size_t>(mesh.region[t])] += volumes[t];
    LiverVolumes result{std::accumulate(region_volume.begin(), region_volume.end(), 0.0), {}};
    for (std::size_t r = 0; r < region_volume.size(); ++r)
        if (const auto role = role_of_name(mesh.region_names[r]);
            role == SegmentRole::lesion || role == SegmentRole::cyst)
            result.lesions.push_back(region_volume[r]);
    return result;
}

std::vector<std::string> doubts_about_share(const LiverVolumes &volumes) {
    const double lesion_volume = std::accumulate(volumes.lesions.begin(), volumes.lesions.end(), 0.0);
    if (!(lesion_volume > 0.5 * volumes.all))
        return {};
    return {fmt::format("lesions are {:.0f} % of the body, more than the liver around them; check whether liver and "
                        "lesions have been exchanged",
                        100.0 * lesion_volume / volumes.all)};
}

} // namespace

std::vector<std::string> doubts_about_liver(double volume, std::span<const double> lesions) {
    constexpr double litres_per_cubic_metre = 1e3;
    std::vector<std::string> doubts;
    const double litres = litres_per_cubic_metre * volume;
    if (!(litres >= smallest_liver && litres <= largest_liver))
        doubts.push_back(fmt::format("the body has {:.2g} L, where an adult liver has {} to {} L; check its lengths, "
                                     "and whether it is a whole liver",
                                     litres, smallest_liver, largest_liver));
    for (auto &doubt : doubts_about_share({volume, {lesions.begin(), lesions.end()}}))
        doubts.push_back(std::move(doubt));
    return doubts;
}

std::vector<std::string> doubts_about_liver(const TetraMesh &mesh) {
    const auto volumes = liver_volumes(mesh);
    return doubts_about_liver(volumes.all, volumes.lesions);
}

std::vector<std::string> doubts_about_lesions(const TetraMesh &mesh) {
    return doubts_about_share(liver_volumes(mesh));
}

std::vector<std::string> doubts_about_unit(const std::vector<Vector3> &points) {
    constexpr double smallest_sample = 1e-3; // [m]
    constexpr double most_litres = 1000.0;   // of the box around it
    const Vector3 sides = bounding_box(points).sizes();
    const double longest = sides.maxCoeff(), litres = 1e3 * sides.prod();
    if (longest > largest_organ)
        return {fmt::format("the longest side is {:.4g} m, which fits no organ; check whether the lengths are in mm",
                            longest)};
    if (longest < smallest_sample)
        return {fmt::format(
            "the longest side is {:.4g} m, which fits no organ; check whether the lengths are in m already", longest)};
    if (litres > most_litres)
        return {fmt::format("the box around it holds {:.4g} L, which fits no organ; check the unit of the lengths",
                            litres)};
    return {};
}

std::vector<std::string> doubts_about_materials(std::span<const Material> materials,
                                                std::span<const std::string> names) {
    constexpr double lightest = 100.0, heaviest = 5000.0; // [kg/m^3] a lung, and more than tooth
    constexpr double softest = 50.0, stiffest = 1e8;      // [Pa] softer gels flow, and silicones are far below
    std::vector<std::string> doubts;
    for (std::size_t m = 0; m < materials.size(); ++m) {
        const double density = materials[m].density, modulus = materials[m].young_modulus;
        if (!(density >= lightest && density <= heaviest))
            doubts.push_back(
                fmt::format("region '{}' has a density of {:g} kg/m^3, which fits no tissue; check whether "
                            "it is in kg/m^3, in which water has 1000",
                            names[m], density));
        if (!(modulus >= softest && modulus <= stiffest))
            doubts.push_back(fmt::format("region '{}' has a Young's modulus of {:g} Pa, which fits no tissue; check "
                                         "whether it is in Pa, in which a liver has some thousands",
                                         names[m], modulus));
    }
    return doubts;
}

std::vector<std::string> doubts_about_loads(const LoadCase &load_case, const TetraMesh &mesh) {
    constexpr double largest_traction = 1e6, largest_force = 1e3; // [Pa] and [N]
    constexpr double largest_acceleration = 1e3;                  // [m/s^2]
    if (load_case.scale_to_target)
        return {};
    struct Sums {
        double traction = 0.0, displacement = 0.0; ///< the largest [Pa, m]
        Vector3 force = Vector3::Zero();           ///< [N]
    };
    std::vector<Sums> place_sums(load_case.conditions.size());
    for (int f = 0; f < load_case.num_facets(); ++f) {
        if (load_case.is_free(f) || load_case.presses(f))
            continue;
        auto &sums = place_sums[static_cast<std::size_t>(load_case.condition_on[f])];
        const Vector3 value = load_case.value[f].array().isNaN().select(0.0, load_case.value[f].array()).matrix();
        if (load_case.is_constrained(f)) {
            sums.displacement = std::max(sums.displacement, value.norm());
        } else {
            sums.traction = std::max(sums.traction, value.norm());
            sums.force += area_vector(mesh, f).norm() * value;
        }
    }
    const double size = bounding_box(mesh.points).diagonal().norm();
    std::vector<std::string> doubts;
    const auto doubt = [&](const std::string &place, const std::string &what, const char *unit) {
        doubts.push_back(
            fmt::format("{}: '{}' has {}; check the number, which is in {}", load_case.name, place, what, unit));
    };
    for (std::size_t c = 0; c < place_sums.size(); ++c) {
        const auto &place = load_case.conditions[c].place;
        const auto &sums = place_sums[c];
        if (sums.traction > largest_traction)
            doubt(place,
                  fmt::format("a traction of {:.3g} Pa, where no instrument exerts more than {:g} Pa on tissue",
                              sums.traction, largest_traction),
                  "Pa");
        else if (sums.force.norm() > largest_force)
            doubt(place, fmt::format("a force of {:.3g} N, more than a hand exerts", sums.force.norm()), "N");
        if (sums.displacement > size)
            doubt(place,
                  fmt::format("a displacement of {:.3g} m, and the body is {:.3g} m across", sums.displacement, size),
                  "m unless the load case says its 'unit'");
    }
    if (load_case.press_depth > size)
        doubt("press", fmt::format("a depth of {:.3g} m, and the body is {:.3g} m across", load_case.press_depth, size),
              "m unless the load case says its 'unit'");
    if (load_case.acceleration.norm() > largest_acceleration)
        doubt("acceleration",
              fmt::format("{:.3g} m/s^2, more than a hundred times gravity", load_case.acceleration.norm()), "m/s^2");
    return doubts;
}

std::vector<std::string> doubts_about_noise(double noise, double largest) {
    constexpr double worst_camera = 0.01, most_of_largest = 0.1; // [m], and a part
    if (!(noise > std::min(worst_camera, most_of_largest * largest)))
        return {};
    return {fmt::format("the noise is {:g} m, and the largest displacement that was measured is {:.3g} m; check "
                        "whether the noise is in m, because errors below it rank nothing",
                        noise, largest)};
}

std::optional<std::pair<std::size_t, std::size_t>> apart_by_faces(std::span<const std::array<int, 4>> tetrahedra) {
    const auto part = parts_by_faces(tetrahedra);
    const auto other = std::ranges::find_if(part, [](int number) { return number != 0; });
    if (other != part.end())
        return std::pair(std::size_t{0}, static_cast<std::size_t>(other - part.begin()));
    return std::nullopt;
}

} // namespace livermark::core
