#pragma once

#include <array>
#include <span>
#include <string_view>

namespace terravox::page {

/// A file of the web page, as it is part of the program. All texts live as long as the program.
struct Asset {
    std::string_view path;  ///< its name: "index.html", "app.js", "app.css", "viewer.html", ...
    std::string_view content_type;  ///< for the header of that name
    std::string_view bytes;
};

/// All files of the page. "index.html" is meant for `/` and refers to the others as `page/NAME`,
/// relative to itself, so that the page also works behind a proxy that adds a path. It needs no
/// more of a `Content-Security-Policy` than scripts, styles, connections and images of `'self'`,
/// and images as `blob:` and `data:`. Thread-safe.
[[nodiscard]] std::span<const Asset> assets() noexcept;

/// What "viewer.html" refers to as `viewer/NAME`, and the licences of its parts.
inline constexpr std::array<std::string_view, 4> kViewerFiles = {"viewer.js", "worker.js",
                                                                 "viewer.css", "licences.txt"};

/// @return the file of that name, or nullptr. Thread-safe.
[[nodiscard]] const Asset* find(std::string_view path) noexcept;

/// docs/openapi.json: the interface, for programs.
[[nodiscard]] std::string_view open_api() noexcept;

/// appearance.bin (docs/formats/site.md) of the materials in config/materials.toml as they were
/// when the program was built, and of clear air at sea level.
[[nodiscard]] std::string_view default_appearance() noexcept;

}  // namespace terravox::page
