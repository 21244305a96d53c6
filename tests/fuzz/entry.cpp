// What libFuzzer calls.
#include <spdlog/spdlog.h>

#include "tests/fuzz/fuzz.hpp"

extern "C" int LLVMFuzzerInitialize(int*, char***) {
    spdlog::set_level(spdlog::level::off);
    return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
    terravox::fuzz::allow_errors([&] { terravox::fuzz::run({bytes, size}); });
    return 0;
}
