#pragma once

// Catch2 2 (Debian 12) and Catch2 3 (Ubuntu 24.04) under one name. Tests include this file and
// nothing of Catch2 itself.

#include <string>

#if __has_include(<catch2/catch_all.hpp>)
#include <catch2/catch_all.hpp>
using Catch::Approx;
#else
#include <catch2/catch.hpp>
#endif

namespace terravox::test {

/// A matcher for CHECK_THAT and CHECK_THROWS_WITH: the text holds `part`.
inline auto contains(const std::string& part) {
#if __has_include(<catch2/catch_all.hpp>)
    return Catch::Matchers::ContainsSubstring(part);
#else
    return Catch::Matchers::Contains(part);
#endif
}

}  // namespace terravox::test
