#pragma once

#include <span>
#include <string>
#include <vector>

#include "report/plot.hpp"
#include "results/result.hpp"

/// Who and what there is in results, in the order in which it appears.
namespace livermark::report {

/// results::body_label() of all, each once.
std::vector<std::string> body_labels(std::span<const results::Result> results);

/// Names of the models of all, each once.
std::vector<std::string> model_names(std::span<const results::Result> results);

/// The model that the others are compared with; empty if none was compared.
std::string reference_of(const results::Result &result);

/// None if it is not there.
const results::ModelResult *find_model(const results::Result &result, const std::string &name);

/// The model's relative L2 error if it came to an end and was compared, else NaN.
double error_of(const results::ModelResult &model);

/// Whether it is made of springs or moves in explicit steps, so that finite elements are what it is measured by.
bool is_spring_model(const results::ModelResult &model);

/// The spring model with the smallest error; none if there is none with an error.
const results::ModelResult *best_spring_model(const results::Result &result);

/// The same colour and marker for a model wherever it is drawn: finite elements in greys, others in colours.
SeriesStyle style_of(const std::string &model, const std::vector<std::string> &all);

/// @param values  at least one
double mean(const std::vector<double> &values);

/// The command lines of results.
std::vector<std::string> commands_of(std::span<const results::Result> results);

} // namespace livermark::report
