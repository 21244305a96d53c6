#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace terravox::scene {

/// A name as it is compared: lower case (ASCII, and the Latin letters of two bytes in UTF-8), words
/// apart by one blank.
[[nodiscard]] std::string folded(const std::string& name);

/// How many bytes have to be changed, added or left out to make one of the other.
/// Ref: Wagner & Fischer, "The String-to-String Correction Problem", 1974.
[[nodiscard]] std::size_t edit_distance(const std::string& a, const std::string& b);

/// Those of `names` that somebody may have meant: nearly the same, or one holds the other; the
/// nearest first, at most `most`.
[[nodiscard]] std::vector<std::string> near_names(const std::string& asked,
                                                  const std::vector<std::string>& names,
                                                  std::size_t most = 5);

}  // namespace terravox::scene
