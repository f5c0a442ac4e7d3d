#include <fstream>

#include "meshes/io/mesh_files.hpp"
#include "tests/app/cli/bad_inputs/bad_inputs.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::tests {

namespace {

namespace fs = std::filesystem;

/// The bar of 90 x 30 x 30 mm with edges of a third of its height.
void write_finer_bar(const fs::path &folder) {
    write_bar(folder);
    meshes::write_msh(folder / "bar.msh", box_mesh({0.09, 0.03, 0.03}, {9, 3, 3}));
}

/// Across the bar, from above its upper face down to a height.
std::string blade_down_to(const std::string &z) {
    return "0.041 -0.01 0.04 0.041 0.04 0.04 0.041 0.04 " + z + " 0.041 -0.01 " + z;
}

/// `livermark cut` of the finer bar while it is pulled.
BadInput blade(std::string name, std::string what, const std::string &words, std::string place, std::string remedy,
               const std::string &load_case = good_case) {
    return {.name = std::move(name),
            .what = std::move(what),
            .arguments = "cut bar.toml --load-case case.toml --output out " + words,
            .file = "",
            .place = std::move(place),
            .remedy = std::move(remedy),
            .files = {{"case.toml", load_case}},
            .prepare = write_finer_bar};
}

BadInput on_cut_bar() {
    auto row = blade("BladeThatHasBeenThere", "a blade where the body is cut already",
                     "--blade " + blade_down_to("0.015"), "parts no face", "where that is not cut yet");
    row.files["bar.toml"] = good_body + "[[cut]]\nblade = { corners = [[0.041, -0.01, 0.04], [0.041, 0.04, 0.04], "
                                        "[0.041, 0.04, 0.015], [0.041, -0.01, 0.015]] }\n";
    return row;
}

} // namespace

std::vector<BadInput> bad_blades() {
    const auto half = "--blade " + blade_down_to("0.015");
    const std::string pressed = replaced(good_case, "traction = [10.0, 0.0, 0.0]", "press = 0.001");
    const std::string all_gone =
        good_case + "[[cut]]\nhalf_space = { point = [-0.05, 0.0, 0.0], normal = [1.0, 0.0, 0.0] }\n";
    return {
        blade("NoBlade", "a cut without a blade", "", "--blade is required", "see `livermark cut --help`"),
        blade("ElevenNumbers", "a blade of eleven numbers", "--blade 0 0 0 1 0 0 1 1 0 0 1", "--blade",
              "see `livermark cut --help`"),
        blade("BladeWithoutArea", "a blade that goes nowhere", "--blade " + blade_down_to("0.04"),
              "the corners of the blade", "give four in turn"),
        blade("InfiniteBlade", "a blade that goes to infinity", "--blade " + blade_down_to("inf"), "not finite",
              "correct it"),
        blade("BladeBesideTheBody", "a blade that misses on all of its way", "--blade 1 0 0 2 0 0 2 1 0 1 1 0",
              "parts no face", "let it go through the body"),
        on_cut_bar(),
        blade("BladeAllThrough", "a blade that goes all the way through", "--blade " + blade_down_to("-0.01"),
              "leaves 2 pieces", "let it end before that"),
        blade("BladeThroughWhatIsHeld", "a blade that cuts off what is held",
              "--blade 0.011 -0.01 0.04 0.011 0.04 0.04 0.011 0.04 -0.01 0.011 -0.01 -0.01", "leaves 2 pieces",
              "let it end before that"),
        blade("NothingLeftForTheBlade", "a blade after a cut that takes the whole body", half,
              "case.toml:9:", "take a smaller part", all_gone),
        blade("BladeInNoSteps", "a blade that goes in in no steps", half + " --steps 0", "--steps is 0",
              "give 1 to 1000"),
        blade("NegativeToughness", "negative toughness", half + " --toughness -1", "--toughness is -1",
              "give 0 or more"),
        blade("BladeUnderAPress", "a blade while a press goes on", half, "loads that change", "choose one with",
              pressed),
        blade("BladeUnderWeight", "a blade while a body bears its weight", half, "has an acceleration",
              "choose one with", "acceleration = [0.0, 0.0, -9.81]\n" + good_case),
        blade("BladeAfterARelease", "a blade while a body moves", half, "loads that change", "choose one with",
              good_release),
        blade("ModelOfTheOtherRegime", "a model of the other regime under a blade",
              half + " --model fem_p1_neo_hookean", "fem_p1_neo_hookean takes no part", "leave it out"),
        blade("MisspeltRegimeUnderABlade", "a misspelt regime under a blade", half + " --regime lagre", "--regime",
              "did you mean 'large'?"),
        blade("RefinedOnce", "a reference that is refined once, which says no error", half + " --refine 1",
              "--refine is 1", "give 0 for no error bar"),
        blade("UnknownMethodUnderABlade", "a misspelt method under a blade", half + " --method tlde", "'tlde'",
              "did you mean 'tled'?"),
        blade("BladeWithoutFrames", "a blade that goes on in no frames", half + " --method tled --frames 0",
              "--frames is 0", "give 1 to 1000"),
        blade("MethodUnderAGrip", "a method that moves where a place is displaced", half + " --method tled",
              "displaces a place", "choose one with tractions or forces",
              replaced(good_case, "traction = [10.0, 0.0, 0.0]", "displacement = [0.001, 0.0, 0.0]")),
        blade("UnknownModelUnderABlade", "a misspelt model under a blade", half + " --model llyod", "'llyod'",
              "did you mean 'lloyd'?"),
    };
}

} // namespace livermark::tests
