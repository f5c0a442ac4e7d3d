#include "meshes/io/mesh_files.hpp"
#include "tests/app/cli/bad_inputs/bad_inputs.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::tests {

namespace {

BadInput load_case(std::string what, std::string text) {
    return {std::move(what), good_run, {{"case.toml", std::move(text)}}, write_bar};
}

BadInput spoilt_load_case(std::string what, const std::string &from, const std::string &to) {
    return load_case(std::move(what), replaced(good_case, from, to));
}

BadInput spoilt_release(std::string what, const std::string &from, const std::string &to) {
    return load_case(std::move(what), replaced(good_release, from, to));
}

/// The bar of 90 x 30 x 30 mm, cut.
BadInput cut(std::string what, const std::string &words) {
    return load_case(std::move(what), good_case + "[[cut]]\n" + words + "\n");
}

/// The bar that is pulled, slowly.
BadInput history(std::string what, const std::string &words) {
    return load_case(std::move(what), good_case + "[history]\n" + words + "\n");
}

const std::string held_bar = R"(title = "held"
regime = "large"
path = [0.5, 1.0]
target_peak_displacement = 0.001
[[condition]]
patch = "x_min"
displacement = [0.0, 0.0, 0.0]
)";

/// The bar that is held and touched.
BadInput touch(std::string what, const std::string &words) {
    return load_case(std::move(what), held_bar + "[touch]\n" + words + "\n");
}

/// The bar that is held and stands on springs.
BadInput foundation(std::string what, const std::string &words) {
    return load_case(std::move(what), held_bar + "[foundation]\n" + words + "\n");
}

/// The bar with edges of a third of its height.
void write_finer_bar(const std::filesystem::path &folder) {
    write_bar(folder);
    meshes::write_msh(folder / "bar.msh", box_mesh({0.09, 0.03, 0.03}, {9, 3, 3}));
}

/// Across the bar, from above its upper face down to a height.
std::string blade_down_to(const std::string &z) {
    return "0.041 -0.01 0.04 0.041 0.04 0.04 0.041 0.04 " + z + " 0.041 -0.01 " + z;
}

/// `livermark cut` of the finer bar while it is pulled.
BadInput blade(std::string what, const std::string &words, const std::string &text = good_case) {
    return {std::move(what),
            "cut bar.toml --load-case case.toml --output out " + words,
            {{"case.toml", text}},
            write_finer_bar};
}

BadInput on_cut_bar() {
    auto row = blade("a blade where the body is cut already", "--blade " + blade_down_to("0.015"));
    row.files["bar.toml"] = good_body + "[[cut]]\nblade = { corners = [[0.041, -0.01, 0.04], [0.041, 0.04, 0.04], "
                                        "[0.041, 0.04, 0.015], [0.041, -0.01, 0.015]] }\n";
    return row;
}

} // namespace

std::vector<BadInput> bad_cuts() {
    const std::string beyond = "half_space = { point = [0.05, 0.0, 0.0], normal = [1.0, 0.0, 0.0] }";
    const std::string through = "blade = { corners = [[0.045, -1.0, -1.0], [0.045, 1.0, -1.0], [0.045, 1.0, 1.0], "
                                "[0.045, -1.0, 1.0]] }";
    return {
        cut("a cut without a region, a half-space or a blade", "way = \"exact\""),
        cut("a cut with two tools", beyond + "\n" + through),
        cut("a misspelt key of a cut", "regoin = \"solid\""),
        cut("a way that is none", beyond + "\nway = \"fast\""),
        cut("a cut of a region that the body lacks", "region = \"tumour_1\""),
        cut("a negative margin", "region = \"solid\"\nmargin = -0.005"),
        cut("a blade of three corners", "blade = { corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]] }"),
        cut("a blade whose corners are on one line",
            "blade = { corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0]] }"),
        cut("a cut beside the body", replaced(beyond, "0.05", "0.5")),
        cut("a blade beside the body", "blade = { corners = [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], "
                                       "[2.0, 1.0, 0.0], [1.0, 1.0, 0.0]] }"),
        cut("a cut that takes the whole body", replaced(beyond, "0.05", "-0.05")),
        cut("a cut that takes what is held", "half_space = { point = [0.05, 0.0, 0.0], normal = [-1.0, 0.0, 0.0] }"),
        cut("a cut that leaves a piece that floats", through),
        cut("the same cut twice", beyond + "\n[[cut]]\n" + beyond),
        cut("pieces that are kept in a load case", through + "\nsmall_pieces = \"keep\""),
    };
}

std::vector<BadInput> bad_load_cases() {
    const std::string constrained = "displacement = [0.0, 0.0, 0.0]", pulled = "traction = [10.0, 0.0, 0.0]";
    const std::string end = "patch = \"x_max\"";
    return {
        load_case("an empty load case", ""),
        load_case("random bytes as a load case", random_bytes()),
        load_case("a load case that ends in a list", good_case.substr(0, good_case.find(", 0.0, 0.0]"))),
        spoilt_load_case("a misspelt key", "title", "titel"),
        spoilt_load_case("a misspelt key of a condition", "traction", "tractoin"),
        spoilt_load_case("a misspelt key of a disc", end, "disc = { patch = \"x_max\", raduis = 0.01 }"),
        spoilt_load_case("a negative target", "= 0.001", "= -0.001"),
        spoilt_load_case("a traction with its unit", "[10.0, 0.0, 0.0]", "\"10 Pa\""),
        spoilt_load_case("a displacement of two components", "[0.0, 0.0, 0.0]", "[0.0, 0.0]"),
        spoilt_load_case("NaN as a traction", "[10.0, 0.0, 0.0]", "[nan, 0.0, 0.0]"),
        load_case("a load case without conditions", "title = \"t\"\ntarget_peak_displacement = 0.001\n"),
        spoilt_load_case("a patch that the body lacks", "\"x_max\"", "\"xmax\""),
        spoilt_load_case("a region that the body lacks", end, "disc = { region = \"tumour_1\", radius = 0.01 }"),
        spoilt_load_case("a place that no facet is in", end,
                         "disc = { point = [0.1, 0.05, 0.05], direction = [1.0, 0.0, 0.0], radius = 0.01 }"),
        spoilt_load_case("a point in mm", end, "disc = { point = [45.0, 15.0, 30.0], radius = 0.01 }"),
        spoilt_load_case("a radius in mm", end, "disc = { patch = \"x_max\", radius = 10.0 }"),
        spoilt_load_case("a traction of 1e300", "[10.0, 0.0, 0.0]", "[1e300, 0.0, 0.0]"),
        spoilt_load_case("a negative radius", end, "disc = { patch = \"x_max\", radius = -0.01 }"),
        spoilt_load_case("a condition at two places", end, end + "\nrest = true"),
        spoilt_load_case("a condition with both a traction and a displacement", pulled, pulled + "\n" + constrained),
        spoilt_load_case("two conditions on the same facets", end, "patch = \"x_min\""),
        spoilt_load_case("two conditions that move one node differently", end + "\n" + pulled,
                         "patch = \"y_min\"\ndisplacement = [0.0, 0.0, 0.002]"),
        spoilt_load_case("a body without a constraint", constrained, "traction = [-10.0, 0.0, 0.0]"),
        spoilt_load_case("a body that can slide", constrained, "displacement = [0.0, 0.0, \"free\"]"),
        load_case("a body that can turn",
                  replaced(replaced(good_case, constrained, "displacement = [\"free\", \"free\", 0.0]"),
                           end + "\n" + pulled,
                           "patch = \"y_min\"\ndisplacement = [\"free\", 0.0, \"free\"]\n[[condition]]\n"
                           "patch = \"z_min\"\ndisplacement = [0.0, \"free\", \"free\"]")),
        load_case("scaling where nothing moves the body",
                  "scale_to_target = true\n" + replaced(good_case, "10.0", "0.0")),
    };
}

std::vector<BadInput> bad_releases() {
    return {
        spoilt_release("a release without a load", "traction = [10.0", "displacement = [0.001"),
        spoilt_release("a release without a probe", "[[probe]]\nname = \"end\"\npatch = \"x_max\"\n", ""),
        load_case("a probe without a release", good_case + "[[probe]]\nname = \"end\"\npatch = \"x_max\"\n"),
        spoilt_release("a probe at a constrained node", "\"end\"\npatch = \"x_max\"", "\"end\"\npatch = \"x_min\""),
        spoilt_release("a duration in microseconds", "duration = 1.0", "duration = 1000000"),
        spoilt_release("damping that is given twice", "[[probe]]", "alpha = 1.0\n[[probe]]"),
        {"a time step that is too long to be stable",
         good_run + " --time-step 0.5",
         {{"case.toml", good_release}},
         write_bar},
    };
}

std::vector<BadInput> bad_blades() {
    const auto half = "--blade " + blade_down_to("0.015");
    const std::string pressed = replaced(good_case, "traction = [10.0, 0.0, 0.0]", "press = 0.001");
    const std::string all_gone =
        good_case + "[[cut]]\nhalf_space = { point = [-0.05, 0.0, 0.0], normal = [1.0, 0.0, 0.0] }\n";
    return {
        blade("a cut without a blade", ""),
        blade("a blade of eleven numbers", "--blade 0 0 0 1 0 0 1 1 0 0 1"),
        blade("a blade that goes nowhere", "--blade " + blade_down_to("0.04")),
        blade("a blade that goes to infinity", "--blade " + blade_down_to("inf")),
        blade("a blade that misses on all of its way", "--blade 1 0 0 2 0 0 2 1 0 1 1 0"),
        on_cut_bar(),
        blade("a blade that goes all the way through", "--blade " + blade_down_to("-0.01")),
        blade("a blade that cuts off what is held",
              "--blade 0.011 -0.01 0.04 0.011 0.04 0.04 0.011 0.04 -0.01 0.011 -0.01 -0.01"),
        blade("a blade after a cut that takes the whole body", half, all_gone),
        blade("a blade that goes in in no steps", half + " --steps 0"),
        blade("negative toughness", half + " --toughness -1"),
        blade("a blade while a press goes on", half, pressed),
        blade("a blade while a body bears its weight", half, "acceleration = [0.0, 0.0, -9.81]\n" + good_case),
        blade("a blade while a body moves", half, good_release),
        blade("a model of the other regime under a blade", half + " --model fem_p1_neo_hookean"),
        blade("a misspelt regime under a blade", half + " --regime lagre"),
        blade("a reference that is refined once, which says no error", half + " --refine 1"),
        blade("a misspelt method under a blade", half + " --method tlde"),
        blade("a blade that goes on in no frames", half + " --method tled --frames 0"),
        blade("a method that moves where a place is displaced", half + " --method tled",
              replaced(good_case, "traction = [10.0, 0.0, 0.0]", "displacement = [0.001, 0.0, 0.0]")),
        blade("a misspelt model under a blade", half + " --model llyod"),
    };
}

std::vector<BadInput> bad_histories() {
    const std::string one = "relaxation = { moduli = [0.5], times = [2.0] }\n";
    return {
        history("a history without a Prony series", "press = 1.0"),
        history("a Prony series that does not ship", "relaxation = \"livr\"\npress = 1.0"),
        history("moduli that fade to less than nothing",
                "relaxation = { moduli = [0.6, 0.6], times = [1.0, 2.0] }\npress = 1.0"),
        history("a modulus that grows", "relaxation = { moduli = [-0.1], times = [1.0] }\npress = 1.0"),
        history("fewer times than moduli", "relaxation = { moduli = [0.1, 0.1], times = [1.0] }\npress = 1.0"),
        history("a press in no time", one + "press = 0.0"),
        history("a hold without an end", one + "press = 1.0\nhold = inf"),
        history("a frequency without cycles", one + "frequency = 1.0"),
        history("a hold and cycles", one + "press = 1.0\nfrequency = 1.0\ncycles = 2"),
        history("a million cycles", one + "frequency = 1.0\ncycles = 1000000"),
    };
}

std::vector<BadInput> bad_touches() {
    const std::string on_top = "patch = \"z_max\"\n";
    return {
        touch("a ball without a radius", on_top + "radius = 0.0\ndepth = 0.001"),
        touch("a negative depth", on_top + "radius = 0.01\ndepth = -0.001"),
        touch("a depth of ten metres", on_top + "radius = 0.01\ndepth = 10.0"),
        touch("negative friction", on_top + "radius = 0.01\ndepth = 0.001\nfriction = -0.1"),
        touch("a ball without a place", "radius = 0.01\ndepth = 0.001"),
        touch("a misspelt key of a ball", on_top + "raduis = 0.01\ndepth = 0.001"),
        touch("a ball on what is held", "patch = \"x_min\"\nradius = 0.01\ndepth = 0.001"),
        touch("jaws from what is held", "patch = \"x_max\"\nradius = 0.01\ndepth = 0.001\njaws = true"),
        touch("plates as jaws", on_top + "plate = \"round\"\nsize = 0.01\ndepth = 0.001\njaws = true"),
        touch("jaws that slide", on_top + "radius = 0.01\ndepth = 0.001\nslide = [0.001, 0.0, 0.0]\njaws = true"),
        touch("jaws that would meet", on_top + "radius = 0.01\ndepth = 0.016\njaws = true"),
    };
}

std::vector<BadInput> bad_foundations() {
    const std::string below = "patch = \"z_min\"\n";
    return {
        foundation("springs without a stiffness", below),
        foundation("springs of no stiffness", below + "stiffness = 0.0"),
        foundation("springs without a place", "stiffness = 1e5"),
        foundation("a misspelt key of springs", below + "stifness = 1e5"),
        foundation("springs below what is held", "patch = \"x_min\"\nstiffness = 1e5"),
    };
}

} // namespace livermark::tests
