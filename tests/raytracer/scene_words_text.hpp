#pragma once

#include <ostream>

#include "raytracer/core/base/scene_words.hpp"

namespace terravox::core {

/// So that messages of failed checks show the word.
template <WordEnum Enum>
std::ostream& operator<<(std::ostream& out, Enum value) {
    return out << to_word(value);
}

}  // namespace terravox::core
