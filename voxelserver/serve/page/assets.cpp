#include "voxelserver/serve/page/assets.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

#include "voxelserver/serve/page/embed.hpp"

TERRAVOX_EMBED(index, TERRAVOX_PAGE_FOLDER "/index.html");
TERRAVOX_EMBED(script, TERRAVOX_PAGE_FOLDER "/app.js");
TERRAVOX_EMBED(style, TERRAVOX_PAGE_FOLDER "/app.css");
TERRAVOX_EMBED(viewer, TERRAVOX_PAGE_FOLDER "/viewer.html");
TERRAVOX_EMBED(viewer_script, TERRAVOX_PAGE_FOLDER "/viewer.js");
TERRAVOX_EMBED(worker_script, TERRAVOX_PAGE_FOLDER "/worker.js");
TERRAVOX_EMBED(viewer_style, TERRAVOX_PAGE_FOLDER "/viewer.css");
TERRAVOX_EMBED(licences, TERRAVOX_PAGE_FOLDER "/licences.txt");
TERRAVOX_EMBED(open_api, TERRAVOX_OPEN_API);

namespace terravox::page {
namespace {

std::string_view between(const char* begin, const char* end) noexcept {
    return {begin, static_cast<std::size_t>(end - begin)};
}

}  // namespace

std::string_view open_api() noexcept {
    return between(terravox_page_open_api_begin, terravox_page_open_api_end);
}

std::span<const Asset> assets() noexcept {
    static const std::array all = {
        Asset{"index.html", "text/html; charset=utf-8",
              between(terravox_page_index_begin, terravox_page_index_end)},
        Asset{"app.js", "text/javascript; charset=utf-8",
              between(terravox_page_script_begin, terravox_page_script_end)},
        Asset{"app.css", "text/css; charset=utf-8",
              between(terravox_page_style_begin, terravox_page_style_end)},
        Asset{"viewer.html", "text/html; charset=utf-8",
              between(terravox_page_viewer_begin, terravox_page_viewer_end)},
        Asset{"viewer.js", "text/javascript; charset=utf-8",
              between(terravox_page_viewer_script_begin, terravox_page_viewer_script_end)},
        Asset{"worker.js", "text/javascript; charset=utf-8",
              between(terravox_page_worker_script_begin, terravox_page_worker_script_end)},
        Asset{"viewer.css", "text/css; charset=utf-8",
              between(terravox_page_viewer_style_begin, terravox_page_viewer_style_end)},
        Asset{"licences.txt", "text/plain; charset=utf-8",
              between(terravox_page_licences_begin, terravox_page_licences_end)},
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
