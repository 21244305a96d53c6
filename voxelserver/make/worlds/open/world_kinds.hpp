#pragma once

#include <span>
#include <string>

#include "voxelserver/make/worlds/kind/world_kind.hpp"

namespace terravox::worlds {

/// All kinds, in the order in which they are tried on an input.
[[nodiscard]] std::span<const WorldKind* const> world_kinds() noexcept;

/// The possible inputs, as a list for messages and help.
[[nodiscard]] std::string allowed_inputs();

/// The kind of an input: the first of world_kinds() that recognises it.
/// @throws UsageError for a path that does not exist, or that no kind recognises
[[nodiscard]] const WorldKind& kind_of(const std::string& input);

}  // namespace terravox::worlds
