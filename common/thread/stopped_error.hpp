#pragma once

#include "common/util/error.hpp"

namespace terravox::thread {

/// A box is not fetched since nobody wants it any more: no hole, and nothing to tell anybody.
class StoppedError : public util::Error {
public:
    using util::Error::Error;
};

}  // namespace terravox::thread
