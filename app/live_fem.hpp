#pragma once

#include <filesystem>

#include "server/conversation.hpp"

namespace livermark::app {

/// What the live page holds its springs against: the answer of moving_reference_model, quadratic elements, to the same
/// tractions on the same body, held as open_live_body() says. Messages and their replies:
///
///     young_modulus=<Pa>&poisson_ratio=<nu>   other materials, see live::with_material(); until then those of the file
///     chosen=fem_p2                           the model
///
///     binary float64, little-endian (L,4)     facet, and the traction on it x y z [Pa]; each facet once at most
///     binary float32, little-endian (N,3)     displacement of the nodes [m]
///
/// What is not in the message has no traction; tractions on facets that are held move nothing. The first answer pays
/// for the factor of the stiffness, and so does the first one after another Poisson's ratio. Answers of several
/// conversations wait for each other.
/// @param folder  that is served; absolute, without symlinks and dots
/// @param query   `file=<path>`, of the server's list
/// @throws core::InputError for what open_live_body() refuses; the conversation, for what is not as above
server::Conversation live_fem(const std::filesystem::path &folder, const server::Fields &query);

} // namespace livermark::app
