#include "tests/app/cli/bad_inputs/bad_inputs.hpp"

namespace livermark::tests {

namespace {

BadInput load_case(std::string name, std::string what, std::string text, std::string place, std::string remedy) {
    return {.name = std::move(name),
            .what = std::move(what),
            .arguments = good_run,
            .file = "case.toml:",
            .place = std::move(place),
            .remedy = std::move(remedy),
            .files = {{"case.toml", std::move(text)}},
            .prepare = write_bar};
}

BadInput spoilt_load_case(std::string name, std::string what, const std::string &from, const std::string &to,
                          std::string place, std::string remedy) {
    return load_case(std::move(name), std::move(what), replaced(good_case, from, to), std::move(place),
                     std::move(remedy));
}

BadInput spoilt_release(std::string name, std::string what, const std::string &from, const std::string &to,
                        std::string place, std::string remedy) {
    return load_case(std::move(name), std::move(what), replaced(good_release, from, to), std::move(place),
                     std::move(remedy));
}

/// The bar of 90 x 30 x 30 mm, cut.
BadInput cut(std::string name, std::string what, const std::string &words, std::string place, std::string remedy) {
    return load_case(std::move(name), std::move(what), good_case + "[[cut]]\n" + words + "\n", std::move(place),
                     std::move(remedy));
}

} // namespace

std::vector<BadInput> bad_cuts() {
    const std::string beyond = "half_space = { point = [0.05, 0.0, 0.0], normal = [1.0, 0.0, 0.0] }";
    const std::string through = "blade = { corners = [[0.045, -1.0, -1.0], [0.045, 1.0, -1.0], [0.045, 1.0, 1.0], "
                                "[0.045, -1.0, 1.0]] }";
    return {
        cut("NoTool", "a cut without a region, a half-space or a blade", "way = \"exact\"", ":9:", "give one of them"),
        cut("TwoTools", "a cut with two tools", beyond + "\n" + through, ":9:", "give one of them"),
        cut("UnknownKeyOfACut", "a misspelt key of a cut", "regoin = \"solid\"", ":10:", "did you mean 'region'?"),
        cut("UnknownWay", "a way that is none", beyond + "\nway = \"fast\"", ":9:", "give facets or exact"),
        cut("RegionThatIsNotThere", "a cut of a region that the body lacks", "region = \"tumour_1\"",
            ":9:", "it has solid"),
        cut("NegativeMargin", "a negative margin", "region = \"solid\"\nmargin = -0.005", ":9:", "give 0 or more"),
        cut("ThreeCorners", "a blade of three corners",
            "blade = { corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]] }", ":9:", "four corners"),
        cut("BladeOnALine", "a blade whose corners are on one line",
            "blade = { corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0]] }",
            ":9:", "not on one line"),
        cut("CutOutside", "a cut beside the body", replaced(beyond, "0.05", "0.5"), ":9:", "does not touch"),
        cut("BladeOutside", "a blade beside the body",
            "blade = { corners = [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], "
            "[2.0, 1.0, 0.0], [1.0, 1.0, 0.0]] }",
            ":9:", "let it go deeper"),
        cut("EverythingCut", "a cut that takes the whole body", replaced(beyond, "0.05", "-0.05"),
            ":9:", "take a smaller part"),
        cut("NothingLeftToHold", "a cut that takes what is held",
            "half_space = { point = [0.05, 0.0, 0.0], normal = [-1.0, 0.0, 0.0] }", ":4: the body has no patch 'x_min'",
            "it has x_max"),
        cut("FloatingPiece", "a cut that leaves a piece that floats", through, ":9:", "small pieces 'remove'"),
        cut("SameCutTwice", "the same cut twice", beyond + "\n[[cut]]\n" + beyond, ":11: this repeats the cut at",
            "leave one"),
        cut("SmallPiecesKept", "pieces that are kept in a load case", through + "\nsmall_pieces = \"keep\"",
            ":9:", "livermark mesh cut"),
    };
}

std::vector<BadInput> bad_load_cases() {
    const std::string constrained = "displacement = [0.0, 0.0, 0.0]", pulled = "traction = [10.0, 0.0, 0.0]";
    const std::string end = "patch = \"x_max\"";
    return {
        load_case("EmptyLoadCase", "an empty load case", "", "", "save it again"),
        load_case("RandomBytes", "random bytes as a load case", random_bytes(), ":1:", "correct the line"),
        load_case("Truncated", "a load case that ends in a list", good_case.substr(0, good_case.find(", 0.0, 0.0]")),
                  ":5:", "correct the line"),
        spoilt_load_case("UnknownKey", "a misspelt key", "title", "titel", ":1:", "did you mean 'title'?"),
        spoilt_load_case("UnknownKeyOfACondition", "a misspelt key of a condition", "traction", "tractoin",
                         ":8:", "did you mean 'traction'?"),
        spoilt_load_case("UnknownKeyOfADisc", "a misspelt key of a disc", end,
                         "disc = { patch = \"x_max\", raduis = 0.01 }", ":7:", "did you mean 'radius'?"),
        spoilt_load_case("NegativeTarget", "a negative target", "= 0.001", "= -0.001", ":2:", "has to be positive"),
        spoilt_load_case("UnitBehindANumber", "a traction with its unit", "[10.0, 0.0, 0.0]", "\"10 Pa\"",
                         ":8: 'traction'", "three finite numbers"),
        spoilt_load_case("TwoComponents", "a displacement of two components", "[0.0, 0.0, 0.0]", "[0.0, 0.0]",
                         ":5: 'displacement'", "three finite numbers, or \"free\""),
        spoilt_load_case("NanTraction", "NaN as a traction", "[10.0, 0.0, 0.0]", "[nan, 0.0, 0.0]", ":8: 'traction'",
                         "three finite numbers"),
        load_case("NoCondition", "a load case without conditions", "title = \"t\"\ntarget_peak_displacement = 0.001\n",
                  "[[condition]]", "add one that constrains"),
        spoilt_load_case("UnknownPatch", "a patch that the body lacks", "\"x_max\"", "\"xmax\"", ":7:", "it has x_min"),
        spoilt_load_case("UnknownRegion", "a region that the body lacks", end,
                         "disc = { region = \"tumour_1\", radius = 0.01 }", ":7:", "it has solid"),
        spoilt_load_case("EmptyDisc", "a place that no facet is in", end,
                         "disc = { point = [0.1, 0.05, 0.05], direction = [1.0, 0.0, 0.0], radius = 0.01 }",
                         ":6:", "choose another place or a larger one"),
        spoilt_load_case("PointInMillimetres", "a point in mm", end,
                         "disc = { point = [45.0, 15.0, 30.0], radius = 0.01 }", ":7:", "write unit = \"mm\""),
        spoilt_load_case("RadiusInMillimetres", "a radius in mm", end, "disc = { patch = \"x_max\", radius = 10.0 }",
                         ":7:", "write unit = \"mm\""),
        spoilt_load_case("TractionBeyondArithmetic", "a traction of 1e300", "[10.0, 0.0, 0.0]", "[1e300, 0.0, 0.0]",
                         ":8: 'traction'", "in SI units"),
        spoilt_load_case("NegativeRadius", "a negative radius", end, "disc = { patch = \"x_max\", radius = -0.01 }",
                         ":7:", "has to be positive"),
        spoilt_load_case("TwoPlaces", "a condition at two places", end, end + "\nrest = true",
                         ":6:", "give one of them"),
        spoilt_load_case("TwoEffects", "a condition with both a traction and a displacement", pulled,
                         pulled + "\n" + constrained, ":6:", "give one of them"),
        spoilt_load_case("Overlap", "two conditions on the same facets", end, "patch = \"x_min\"",
                         ":6:", "neither overlap"),
        spoilt_load_case("Contradiction", "two conditions that move one node differently", end + "\n" + pulled,
                         "patch = \"y_min\"\ndisplacement = [0.0, 0.0, 0.002]", "node at (0, 0, 0) m",
                         "neither overlap nor touch"),
        spoilt_load_case("NothingHolds", "a body without a constraint", constrained, "traction = [-10.0, 0.0, 0.0]",
                         "nothing constrains the body", "with a displacement"),
        spoilt_load_case("BodyThatSlides", "a body that can slide", constrained, "displacement = [0.0, 0.0, \"free\"]",
                         "slide along z", "not \"free\" in z"),
        load_case("BodyThatTurns", "a body that can turn",
                  replaced(replaced(good_case, constrained, "displacement = [\"free\", \"free\", 0.0]"),
                           end + "\n" + pulled,
                           "patch = \"y_min\"\ndisplacement = [\"free\", 0.0, \"free\"]\n[[condition]]\n"
                           "patch = \"z_min\"\ndisplacement = [0.0, \"free\", \"free\"]"),
                  "turn about y", "that prevents it"),
        load_case("NothingToScale", "scaling where nothing moves the body",
                  "scale_to_target = true\n" + replaced(good_case, "10.0", "0.0"),
                  ":1:", "leave 'scale_to_target' out"),
    };
}

std::vector<BadInput> bad_releases() {
    return {
        spoilt_release("NothingToLetGo", "a release without a load", "traction = [10.0", "displacement = [0.001",
                       ":9:", "add a [[condition]] with a traction"),
        spoilt_release("NoProbe", "a release without a probe", "[[probe]]\nname = \"end\"\npatch = \"x_max\"\n", "",
                       ":9:", "add one with a name and a patch"),
        load_case("ProbeWithoutRelease", "a probe without a release",
                  good_case + "[[probe]]\nname = \"end\"\npatch = \"x_max\"\n", ":9:", "add one or remove the probe"),
        spoilt_release("ProbeThatIsConstrained", "a probe at a constrained node", "\"end\"\npatch = \"x_max\"",
                       "\"end\"\npatch = \"x_min\"", ":14:", "choose a patch that moves"),
        spoilt_release("DurationInMicroseconds", "a duration in microseconds", "duration = 1.0", "duration = 1000000",
                       ":9:", "from 1 to 1000000"),
        spoilt_release("DampingTwice", "damping that is given twice", "[[probe]]", "alpha = 1.0\n[[probe]]",
                       ":9:", "give one of the two pairs"),
        {.name = "StepTooLong",
         .what = "a time step that is too long to be stable",
         .arguments = good_run + " --time-step 0.5",
         .file = "",
         .place = "a time step of 0.5 s",
         .remedy = "take that, or force the step",
         .files = {{"case.toml", good_release}},
         .prepare = write_bar},
    };
}

} // namespace livermark::tests
