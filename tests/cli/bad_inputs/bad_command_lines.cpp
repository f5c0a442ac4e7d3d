#include "tests/cli/bad_inputs/bad_inputs.hpp"

namespace livermark::tests {

namespace {

BadInput words(std::string name, std::string arguments, std::string place, std::string remedy) {
    return {.name = std::move(name),
            .what = "`livermark" + (arguments.empty() ? "" : " " + arguments) + "`",
            .arguments = std::move(arguments),
            .file = "",
            .place = std::move(place),
            .remedy = std::move(remedy)};
}

/// The same on a bar and a load case that let everything else be right.
BadInput on_bar(std::string name, std::string arguments, std::string place, std::string remedy) {
    auto row = words(std::move(name), std::move(arguments), std::move(place), std::move(remedy));
    row.files["case.toml"] = good_case;
    row.prepare = write_bar;
    return row;
}

} // namespace

std::vector<BadInput> bad_command_lines() {
    return {
        words("Nothing", "", "behind `livermark`", "give one of list"),
        words("MisspeltSubcommand", "rnu", "no subcommand 'rnu'", "did you mean 'run'?"),
        words("MisspeltSecondSubcommand", "mesh chek", "no subcommand 'chek'", "did you mean 'check'?"),
        words("NoSecondSubcommand", "mesh", "subcommands liver, box, cut and check", "see `livermark mesh --help`"),
        words("MisspeltOption", "run --modle lloyd", "no option '--modle'", "did you mean '--model'?"),
        words("UnknownOption", "run --frobnicate", "no option '--frobnicate'", "see `livermark run --help`"),
        words("OptionWithoutValue", "run --young", "--young", "see `livermark run --help`"),
        words("OptionTwice", "run --young 5000 --young 6000", "--young", "see `livermark run --help`"),
        words("WordTooMany", "cohort --bodies 2 --output cohort extra", "'extra'", "leave it out"),
        words("WordMissing", "score beam", "load-case is required", "see `livermark score --help`"),
        words("WordForANumber", "run --young soft", "--young", "see `livermark run --help`"),
        words("NothingToList", "list", "what is required", "see `livermark list --help`"),
        words("UnknownList", "list model", "no choice 'model'", "did you mean 'models'?"),
        words("CohortOfNobody", "cohort --bodies 0 --output cohort", "'0' is not a number of a body", "such as 1-8,12"),
        words("CohortBackwards", "cohort --bodies 8-1 --output cohort", "range 8-1 ends before it begins",
              "such as 1-8,12"),
        words("BodyOfACohortTwice", "cohort --bodies 1-3,2 --output cohort", "2 is given twice", "such as 1-8,12"),
        words("CohortWithoutEnd", "cohort --bodies 1-1001 --output cohort", "more than 1000 bodies", "1000 at most"),
        words("MisspeltModelOfACohort", "cohort --bodies 1 --model loyd --output cohort", "no model 'loyd'",
              "did you mean 'lloyd'?"),
        words("SweepOfNothing", "run --sweep lloyd.a=0.1", "--sweep 'lloyd.a=0.1'", "nodal_springs.a=0.1,0.15,0.25"),
        words("SweepToZero", "run --sweep nodal_springs.a=0.1,0", "'0' is not a number above 0",
              "nodal_springs.a=0.1,0.15,0.25"),
        words("OldNameOfTheReferenceOnTheMesh", "run --no-uncertainty", "--no-uncertainty is now --reference-on-mesh",
              "write that"),
        words("OldNameInACohort", "cohort --bodies 1 --output cohort --no-uncertainty",
              "--no-uncertainty is now --reference-on-mesh", "write that"),
        words("OldNameInAScore", "score beam beam_bend solution.csv --no-uncertainty",
              "--no-uncertainty is now --reference-on-mesh", "write that"),
        words("UnknownKindOfTable", "table --kind overviev", "--kind", "did you mean 'overview'?"),
        words("MisspeltOptionOfAReport", "report --ouptut report.html", "no option '--ouptut'",
              "did you mean '--output'?"),
        words("MisspeltRegime", "run --regime lagre", "--regime", "did you mean 'large'?"),
        words("MisspeltRegimeOfANeedle", "needle --regime lagre", "--regime", "did you mean 'large'?"),
        words("MeasuredNeedleOfTheLargeRegime", "needle --measured --regime large", "of the small regime",
              "leave --regime large out"),
        words("LinearReferenceOfALargeNeedle", "needle --regime large --model fem_p2p1_refined",
              "no model that a needle can be driven into 'fem_p2p1_refined'", "'livermark list models'"),
        words("MisspeltPrecision", "arena --precision singel", "--precision", "did you mean 'single'?"),
        words("MisspeltReference", "reference --model fem_p2_neo_hooke", "--model",
              "did you mean 'fem_p2_neo_hookean'?"),
        words("MeshInAnotherFormat", "mesh box --size 1 1 1 --edge 1 -o box.vtk", "box.vtk", "end its name in .msh"),
        words("LiverInAnotherFormat", "mesh liver -o liver.txt", "liver.txt", "end its name in .msh"),
        words("PhantomTurnedByNan", "mesh --phantom --turn 0 nan 0 -o phantom.nii.gz", "--turn", "give three angles"),
        words("DelaunayBoxTooFine", "mesh box --size 1 1 1 --edge 1e-5 -o box.msh", "the edges are too short",
              "make them longer"),
        words("BoxOfNoPlace", "mesh box --size 1e300 1e300 1e300 --edge 1e299 -o box.msh", "too long to mesh",
              "in metres"),
        words("PortThatIsNone", "view --port 70000", "--port", "not in range 0 to 65535"),
        words("UnknownSolver", "run --fem-solver magic", "--fem-solver", "known are: auto, direct, iterative"),
        words("MisspeltBody", "run --body liver_healty", "no body 'liver_healty'", "did you mean 'liver_healthy'?"),
        words("MisspeltLoadCase", "run --load-case palpatoin", "no load case 'palpatoin'", "did you mean 'palpation'?"),
        words("MisspeltModel", "run --model loyd", "no model 'loyd'", "did you mean 'lloyd'?"),
        words("UnknownModel", "run --model xyzzyxyzzy", "no model 'xyzzyxyzzy'", "'livermark list models' prints"),
        words("BodyTwice", "run --body beam --body beam", "body 'beam'", "name it once"),
        words("NegativeModulus", "run --body beam --young -5", "--young", "has to be positive"),
        words("NanModulus", "run --body beam --young nan", "--young", "has to be positive"),
        words("Incompressible", "run --body beam --poisson 0.5", "--poisson", "between -1 and 0.5"),
        words("NearlyIncompressible", "run --body beam --poisson 0.49999999", "--poisson", "take 0.49999 at most"),
        words("NanPoissonRatio", "run --body beam --poisson nan", "--poisson", "between -1 and 0.5"),
        words("AmplitudeOfZero", "run --amplitude 0", "--amplitude", "finite number above zero"),
        words("NoJobs", "run --jobs 0", "--jobs", "not in range 1 to 1024"),
        words("NegativeTimeStep", "run --time-step -1", "--time-step", "finite number above zero"),
        on_bar("UnknownIntegrator", good_run + " --integrator rk4", "no integrator 'rk4'", "known are: explicit_euler"),
        on_bar("RelaxationWithoutExplicitSteps", good_run + " --equilibrium relaxation --integrator implicit_euler",
               "--equilibrium relaxation", "choose another --integrator"),
        on_bar("RelaxationWithoutStableSteps",
               good_run + " --equilibrium relaxation --integrator runge_kutta_chebyshev", "--equilibrium relaxation",
               "choose another --integrator"),
        words("CalibrationWithoutAFile", "run --model calibrated_nodal_volume", "calibrated_nodal_volume",
              "name it with --calibration"),
        words("ModelWithoutModes", "modes --model fem_p2p1", "'fem_p2p1'", "did you mean 'fem_p1'?"),
        words("ModelTwice", "modes --model fem_p1 --model fem_p1", "'fem_p1'", "name it once"),
        words("NoModes", "modes --count 0", "--count", "1 to 1000"),
        words("MisspeltLoadCaseOfModes", "modes --load-case tracton", "'tracton'", "did you mean 'traction'?"),
        words("MisspeltLaw", "stability --law loyd", "'loyd'", "did you mean 'lloyd'?"),
        on_bar("ElementsThatTakeNoExplicitSteps",
               "stability bar.toml --load-case case.toml --model fem_p2 --output out",
               "model fem_p2 is not made of springs", "such as nodal_springs"),
        words("IntegratorTwice", "stability --integrator heun --integrator heun", "'heun'", "name it once"),
        words("NanDamping", "stability --damping-ratio nan", "--damping-ratio", "finite number of zero or more"),
        words("DampingAtZeroFrequency", "stability --damping-frequencies 0 10", "--damping-frequencies",
              "finite number above zero"),
        words("TwoSidesOfABox", "mesh box --size 1 2 --edge 0.1 -o box.msh", "--size",
              "see `livermark mesh box --help`"),
        words("FlatBox", "mesh box --size 1 0 1 --edge 0.1 -o box.msh", "the size in y", "give a positive length"),
        words("NanEdge", "mesh box --size 1 1 1 --edge nan -o box.msh", "the edge length", "give a positive length"),
        words("CutOfNothing", "mesh cut beam -o cut.msh", "mesh cut", "give one of them"),
        words("MarginOfAPlane", "mesh cut beam --half-space 0.05 0 0 1 0 0 --margin 0.005 -o cut.msh", "a margin",
              "or give a region"),
        words("CutBesideTheBody", "mesh cut beam --half-space 5 0 0 1 0 0 -o cut.msh", "does not touch",
              "livermark mesh check"),
        words("CutWithoutAPlace", "mesh cut beam --half-space 0.05 0 0 1 0 0 -o cut.vtk", "cut.vtk",
              "end its name in .msh"),
        words("LiverTooFine", "mesh liver --tetrahedra 1000000000 -o liver.msh", "--tetrahedra", "2000 to 2000000"),
        words("BoxTooFine", "mesh box --size 1 1 1 --edge 1e-9 --topology kuhn -o box.msh", "the edges are too short",
              "make them longer"),
    };
}

} // namespace livermark::tests
