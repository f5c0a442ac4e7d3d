#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "results/records/result.hpp"

namespace livermark::results {

/// What is not known of a patient, and how far it reaches.
struct UncertainParameter {
    std::string name;
    std::string unit;            ///< SI, or nothing
    std::string group;           ///< "parameters", "support" or "tool"
    double lower = 0.0;          ///< SI
    double upper = 0.0;          ///< above lower
    bool is_logarithmic = false; ///< whether its logarithm is uniform between them, not it
    std::string source;          ///< of the range
    bool operator==(const UncertainParameter &) const = default;

    /// The value below which a share u of all patients lies, u in [0, 1].
    double at(double u) const {
        return is_logarithmic ? lower * std::pow(upper / lower, u) : lower + u * (upper - lower);
    }
};

/// How one output depends on the parameters: Sobol indices, and intervals that hold 95 % of what points drawn again
/// with replacement give.
struct OutputSensitivity {
    std::string name, unit;
    double nominal = 0.0;                                      ///< of the body and the load case as they are
    double mean = 0.0, deviation = 0.0;                        ///< of the samples: mean, standard deviation
    double lower = 0.0, upper = 0.0;                           ///< between which 95 % of them are
    double unexplained = 0.0;                                  ///< part of the variance that the polynomial misses
    std::vector<double> first{}, first_lower{}, first_upper{}; ///< (P) V(E(y | x_p)) / V(y)
    std::vector<double> total{}, total_lower{}, total_upper{}; ///< (P) 1 - V(E(y | all but x_p)) / V(y)
    std::vector<double> group_total{};                         ///< (G) total of all parameters of a group together
    bool operator==(const OutputSensitivity &) const = default;

    /// What the output varies by while one parameter, or nothing where it is negative, is known: standard deviation
    /// over the mean.
    double relative_deviation(int known = -1) const {
        return deviation / std::abs(mean) * std::sqrt(known < 0 ? 1.0 : std::max(0.0, 1.0 - first[known]));
    }
    /// The same of a group alone, with what it does together with others.
    double relative_deviation_of_group(std::size_t group) const {
        return deviation / std::abs(mean) * std::sqrt(group_total[group]);
    }
};

/// What one model is off by in each output, relative; NaN where it found no solution.
struct BudgetModel {
    std::string name;
    std::vector<double> error; ///< (O)
};

/// What an output is uncertain by, relative, from everything but the patient (ASME V&V 20); NaN where nothing is known
/// or nothing applies.
struct ErrorBudget {
    std::string reference;           ///< that models are compared with
    std::vector<double> mesh;        ///< (O) error bar of the reference
    std::vector<double> law;         ///< (O) Ogden's over the neo-Hookean law under the large load case, minus 1
    std::vector<double> measurement; ///< (O) noise of a measured displacement
    std::vector<BudgetModel> models;
};

/// What an answer is worth: the content of one sensitivity file.
struct Sensitivity {
    Provenance provenance;
    std::string body, load_case, title;
    std::string model;       ///< that solved the samples
    std::string fingerprint; ///< of the body, the load case and the model: samples of others are not gone on with
    std::vector<UncertainParameter> parameters; ///< (P) that are sampled
    std::vector<std::string> groups;            ///< (G) of these, in their order
    std::vector<std::vector<double>> points;    ///< (S, P) SI
    std::vector<std::vector<double>> values;    ///< (S, O) SI; NaN where there is no solution
    std::vector<OutputSensitivity> outputs;     ///< (O)
    ErrorBudget budget;
};

} // namespace livermark::results
