#pragma once

#include <string_view>

namespace terravox::page {

/// appearance.bin (docs/formats/site.md) of the materials in config/materials.toml as they were
/// when the program was built, and of clear air at sea level. Lives as long as the program.
[[nodiscard]] std::string_view default_appearance() noexcept;

}  // namespace terravox::page
