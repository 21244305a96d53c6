#pragma once

#include <string>

#include "common/util/error.hpp"

namespace terravox::geo {

/// PROJ cannot read its own database: the text of the coordinate reference system is not at fault.
class ProjUnusableError : public util::Error {
public:
    using util::Error::Error;
};

/// Must be called when PROJ has failed to parse something, before the text is blamed: without
/// memory, file descriptors or its database, PROJ rejects every text and does not report why.
/// Thread-safe.
/// @param attempt  the beginning of the message, such as "read the coordinate reference system
/// 'EPSG:3794'"
/// @throws ProjUnusableError
void check_proj_is_usable(const std::string& attempt);

}  // namespace terravox::geo
