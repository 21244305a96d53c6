#pragma once

#include <filesystem>

#include "tests/catch.hpp"

namespace terravox::test {

/// Real survey files in a folder next to the checkout.
inline const std::filesystem::path kShared = TERRAVOX_SHARED_DATA;

/// Whether a real file or folder can be used; says so where a test is skipped without it.
inline bool there(const std::filesystem::path& file) {
    if (std::filesystem::exists(file))
        return true;
    WARN("skipped: " << file.string() << " is not there");
    return false;
}

}  // namespace terravox::test
