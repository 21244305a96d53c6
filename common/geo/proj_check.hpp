#pragma once

#include <string>

#include "common/util/error.hpp"

namespace terravox::geo {

/// PROJ cannot read its own tables: no text of a coordinate reference system is at fault.
class ProjUnusableError : public util::Error {
public:
    using util::Error::Error;
};

/// To be called where PROJ has not understood something, before that is blamed: without memory or
/// descriptors, or without its database, PROJ understands nothing, and does not say why.
/// Thread-safe.
/// @param attempt  begins the message, such as "read the coordinate reference system 'EPSG:3794'"
/// @throws ProjUnusableError
void check_proj_is_usable(const std::string& attempt);

}  // namespace terravox::geo
