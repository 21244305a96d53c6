#pragma once

#include "common/util/error.hpp"

namespace terravox::voxel {

/// The data of a world are no longer those that it was opened from. No hole: boxes that were read
/// before may not stand beside what can be read now, so what is being made of the world ends.
class ChangedError : public util::Error {
public:
    using util::Error::Error;
};

}  // namespace terravox::voxel
