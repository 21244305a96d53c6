#pragma once

#include <cstdint>
#include <functional>
#include <stop_token>

namespace terravox {

/// How a caller watches a call that takes a while, and ends it.
struct Control {
    /// Called now and then with the share that is done, on any thread but one at a time. It must
    /// not throw.
    std::function<void(std::uint64_t done, std::uint64_t total)> progress = {};
    /// Once requested, the call ends with Stopped, as soon as what is being made is finished.
    std::stop_token stop = {};
};

}  // namespace terravox
