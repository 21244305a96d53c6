#include "voxelserver/serve/page/assets.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

// The assembler takes files in as they are: as a C++ array half a megabyte would take the compiler
// seconds. NOLINTBEGIN(cppcoreguidelines-macro-usage): only a preprocessor can put a path into an
// assembler directive

/// Defines terravox_page_SYMBOL, a function that returns the bytes of a file.
#define TERRAVOX_EMBED(symbol, file)                                                        \
    asm(".global terravox_page_" #symbol "_begin, terravox_page_" #symbol                   \
        "_end\n"                                                                            \
        ".pushsection .rodata.terravox_page,\"a\",@progbits\n"                              \
        "terravox_page_" #symbol                                                            \
        "_begin:\n"                                                                         \
        ".incbin \"" file                                                                   \
        "\"\n"                                                                              \
        "terravox_page_" #symbol                                                            \
        "_end:\n"                                                                           \
        ".byte 0\n"                                                                         \
        ".popsection\n");                                                                   \
    extern "C" const char terravox_page_##symbol##_begin[], terravox_page_##symbol##_end[]; \
    static std::string_view terravox_page_##symbol() noexcept {                             \
        const auto size = terravox_page_##symbol##_end - terravox_page_##symbol##_begin;    \
        return {terravox_page_##symbol##_begin, static_cast<std::size_t>(size)};            \
    }
// NOLINTEND(cppcoreguidelines-macro-usage)

TERRAVOX_EMBED(index, TERRAVOX_PAGE_FOLDER "/index.html")
TERRAVOX_EMBED(script, TERRAVOX_PAGE_FOLDER "/app.js")
TERRAVOX_EMBED(style, TERRAVOX_PAGE_FOLDER "/app.css")
TERRAVOX_EMBED(viewer, TERRAVOX_PAGE_FOLDER "/viewer.html")
TERRAVOX_EMBED(viewer_script, TERRAVOX_PAGE_FOLDER "/viewer.js")
TERRAVOX_EMBED(worker_script, TERRAVOX_PAGE_FOLDER "/worker.js")
TERRAVOX_EMBED(viewer_style, TERRAVOX_PAGE_FOLDER "/viewer.css")
TERRAVOX_EMBED(licences, TERRAVOX_PAGE_FOLDER "/licences.txt")
TERRAVOX_EMBED(open_api, TERRAVOX_OPEN_API)
TERRAVOX_EMBED(appearance, TERRAVOX_APPEARANCE)

namespace terravox::page {

std::string_view open_api() noexcept {
    return terravox_page_open_api();
}

std::string_view default_appearance() noexcept {
    return terravox_page_appearance();
}

std::span<const Asset> assets() noexcept {
    constexpr std::string_view kHtml = "text/html; charset=utf-8";
    constexpr std::string_view kScript = "text/javascript; charset=utf-8";
    constexpr std::string_view kStyle = "text/css; charset=utf-8";
    static const std::array all = {
        Asset{"index.html", kHtml, terravox_page_index()},
        Asset{"app.js", kScript, terravox_page_script()},
        Asset{"app.css", kStyle, terravox_page_style()},
        Asset{"viewer.html", kHtml, terravox_page_viewer()},
        Asset{"viewer.js", kScript, terravox_page_viewer_script()},
        Asset{"worker.js", kScript, terravox_page_worker_script()},
        Asset{"viewer.css", kStyle, terravox_page_viewer_style()},
        Asset{"licences.txt", "text/plain; charset=utf-8", terravox_page_licences()},
    };
    return all;
}

const Asset* find(std::string_view path) noexcept {
    const auto all = assets();
    const auto found = std::find_if(all.begin(), all.end(),
                                    [&](const Asset& asset) { return asset.path == path; });
    return found == all.end() ? nullptr : &*found;
}

}  // namespace terravox::page
