#pragma once

#include "common/util/error.hpp"

namespace terravox::voxel {

/// The server that a world comes from does not answer, or refuses. Nothing is known of the box: a
/// later request may get it.
class UnreachableError : public util::Error {
public:
    using util::Error::Error;
};

}  // namespace terravox::voxel
