#pragma once

namespace terravox::util {

/// Lets this process have as many descriptors open at once as it may (the soft limit becomes the
/// hard one): who serves many needs some for each.
void allow_many_open_files() noexcept;

}  // namespace terravox::util
