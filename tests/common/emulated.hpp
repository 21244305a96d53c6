#pragma once

#include <cstdlib>

namespace terravox::test {

/// Whether this program runs in an emulator (`./terravox test --arm64`), which counts its own
/// memory and address space to the program's.
[[nodiscard]] inline bool emulated() {
    return std::getenv("TERRAVOX_EMULATED") != nullptr;
}

}  // namespace terravox::test
