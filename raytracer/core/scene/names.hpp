#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace terravox::scene {

/// A name in the form used for comparison: lower case (ASCII, and the Latin letters of two bytes in
/// UTF-8), words separated by one blank.
[[nodiscard]] std::string folded(const std::string& name);

/// The names that may have been meant: nearly the same, or one contains the other; the nearest
/// first, at most `max`.
[[nodiscard]] std::vector<std::string> near_names(const std::string& asked,
                                                  const std::vector<std::string>& names,
                                                  std::size_t max = 5);

}  // namespace terravox::scene
