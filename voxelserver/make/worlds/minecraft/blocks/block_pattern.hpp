#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/voxel/material.hpp"

namespace terravox::minecraft {

/// A property of a block: `lit` = `true`.
struct Property {
    std::string_view name;
    std::string_view value;
};
using Properties = std::span<const Property>;

/// [lit=true]: one property and its accepted values.
struct Condition {
    std::string property;
    std::vector<std::string> values;
    [[nodiscard]] bool holds(Properties properties) const noexcept;
    friend bool operator==(const Condition&, const Condition&) = default;
};

/// Called with a message when a text is invalid; must throw.
using Fail = std::function<void(const std::string&)>;

/// "name[a=1|2,b=3]", parsed.
struct BlockState {
    std::string name;
    std::vector<Condition> conditions;
};
/// @throws what `fail` throws
[[nodiscard]] BlockState block_state_from(std::string_view text, const Fail& fail);

/// A word that may stand in a pattern, and its colour where it has one.
struct Word {
    std::string text;
    std::optional<voxel::Rgb8> colour;
};
using Words = std::map<std::string, std::vector<Word>, std::less<>>;

/// A name that a pattern stands for. May hold '*'.
struct Expanded {
    std::string name;
    std::map<std::string, const Word*, std::less<>> chosen;  ///< the word substituted for {name}
};

/// All names that a pattern with {words} and (alternatives|of|text) stands for, in order;
/// alternatives may hold words.
/// @throws what `fail` throws: an unknown word, a brace that is not closed, more than 4096 names
[[nodiscard]] std::vector<Expanded> expand(std::string_view pattern, const Words& words,
                                           const Fail& fail);

/// How many letters of a pattern stand outside of braces and parentheses, not counting '*'.
[[nodiscard]] std::size_t own_letters(std::string_view pattern) noexcept;

/// @param pattern '*' = any text, including none
[[nodiscard]] bool fits(std::string_view pattern, std::string_view name) noexcept;

}  // namespace terravox::minecraft
