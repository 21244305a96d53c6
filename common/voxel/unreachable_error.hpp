#pragma once

#include "common/util/error.hpp"

namespace terravox::voxel {

/// The server that a world comes from does not respond, or refuses the request. The state of the
/// box is unknown: a later request may succeed.
class UnreachableError : public util::Error {
public:
    using util::Error::Error;
};

}  // namespace terravox::voxel
