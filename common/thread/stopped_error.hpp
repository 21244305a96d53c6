#pragma once

#include "common/util/error.hpp"

namespace terravox {

/// A box is not fetched since nobody wants it any more: no hole, and nothing to tell anybody.
class StoppedError : public Error {
public:
    using Error::Error;
};

}  // namespace terravox
