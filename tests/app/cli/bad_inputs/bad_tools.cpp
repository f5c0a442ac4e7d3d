#include "tests/app/cli/bad_inputs/bad_inputs.hpp"

namespace livermark::tests {

namespace {

BadInput behind(const std::string &text, std::string name, std::string what, const std::string &words,
                std::string place, std::string remedy) {
    return {.name = std::move(name),
            .what = std::move(what),
            .arguments = good_run,
            .file = "case.toml:",
            .place = std::move(place),
            .remedy = std::move(remedy),
            .files = {{"case.toml", text + words + "\n"}},
            .prepare = write_bar};
}

/// The bar that is pulled, slowly.
BadInput history(std::string name, std::string what, const std::string &words, std::string place, std::string remedy) {
    return behind(good_case + "[history]\n", std::move(name), std::move(what), words, std::move(place),
                  std::move(remedy));
}

/// The bar that is held and touched.
BadInput touch(std::string name, std::string what, const std::string &words, std::string place, std::string remedy) {
    const std::string held = R"(title = "touch"
regime = "large"
path = [0.5, 1.0]
target_peak_displacement = 0.001
[[condition]]
patch = "x_min"
displacement = [0.0, 0.0, 0.0]
[touch]
)";
    return behind(held, std::move(name), std::move(what), words, std::move(place), std::move(remedy));
}

} // namespace

std::vector<BadInput> bad_histories() {
    const std::string one = "relaxation = { moduli = [0.5], times = [2.0] }\n";
    return {
        history("NoSeries", "a history without a Prony series", "press = 1.0", ":9: 'relaxation'", "add it"),
        history("UnknownSeries", "a Prony series that does not ship", "relaxation = \"livr\"\npress = 1.0",
                ":10: there is no Prony series 'livr'", "known are: liver_perfused"),
        history("ModuliOfMoreThanOne", "moduli that fade to less than nothing",
                "relaxation = { moduli = [0.6, 0.6], times = [1.0, 2.0] }\npress = 1.0",
                ":10:", "has to be below 1; change them"),
        history("NegativeModulus", "a modulus that grows",
                "relaxation = { moduli = [-0.1], times = [1.0] }\npress = 1.0", ":10:", "none may be negative"),
        history("TimesMissing", "fewer times than moduli",
                "relaxation = { moduli = [0.1, 0.1], times = [1.0] }\npress = 1.0",
                ":10:", "give one time for each modulus"),
        history("NoTimeToPress", "a press in no time", one + "press = 0.0", ":11: 'press' is 0", "positive time"),
        history("EndlessHold", "a hold without an end", one + "press = 1.0\nhold = inf", ":12: 'hold'",
                "finite number"),
        history("CyclesMissing", "a frequency without cycles", one + "frequency = 1.0", ":9: 'cycles'", "add it"),
        history("HoldAndCycles", "a hold and cycles", one + "press = 1.0\nfrequency = 1.0\ncycles = 2",
                ":9:", "give one of the two"),
        history("TooManyCycles", "a million cycles", one + "frequency = 1.0\ncycles = 1000000", ":12: 'cycles'",
                "from 1 to 20"),
    };
}

std::vector<BadInput> bad_touches() {
    const std::string on_top = "patch = \"z_max\"\n";
    return {
        touch("NoBall", "a ball without a radius", on_top + "radius = 0.0\ndepth = 0.001", ":10: 'radius'",
              "has to be positive"),
        touch("BallThatPulls", "a negative depth", on_top + "radius = 0.01\ndepth = -0.001", ":11: 'depth'",
              "has to be positive"),
        touch("BallUnderTheSurface", "a depth of ten metres", on_top + "radius = 0.01\ndepth = 10.0",
              ":11:", "give less depth or a larger radius"),
        touch("NegativeFriction", "negative friction", on_top + "radius = 0.01\ndepth = 0.001\nfriction = -0.1",
              ":12: 'friction'", "zero or more"),
        touch("PlaceOfTheBallMissing", "a ball without a place", "radius = 0.01\ndepth = 0.001",
              ":8:", "give one of them"),
        touch("UnknownKeyOfABall", "a misspelt key of a ball", on_top + "raduis = 0.01\ndepth = 0.001",
              ":10:", "did you mean 'radius'?"),
        touch("BallOnWhatIsHeld", "a ball on what is held", "patch = \"x_min\"\nradius = 0.01\ndepth = 0.001",
              ":8:", "choose another place"),
    };
}

} // namespace livermark::tests
