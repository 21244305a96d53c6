#pragma once

#include "common/util/error.hpp"

namespace terravox::thread {

/// A fetch of a box was cancelled because the box is no longer needed: neither a hole nor an error
/// to report.
class StoppedError : public util::Error {
public:
    using util::Error::Error;
};

}  // namespace terravox::thread
