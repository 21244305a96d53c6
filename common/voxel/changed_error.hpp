#pragma once

#include "common/util/error.hpp"

namespace terravox::voxel {

/// The data of a world have changed since it was opened. This is not a hole: boxes read before and
/// boxes read now may not match, so the output in progress must be abandoned.
class ChangedError : public util::Error {
public:
    using util::Error::Error;
};

}  // namespace terravox::voxel
