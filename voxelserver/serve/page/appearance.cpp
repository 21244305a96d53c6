#include "voxelserver/serve/page/appearance.hpp"

#include <cstddef>

#include "voxelserver/serve/page/embed.hpp"

TERRAVOX_EMBED(appearance, TERRAVOX_APPEARANCE);

namespace terravox::page {

std::string_view default_appearance() noexcept {
    const auto size = terravox_page_appearance_end - terravox_page_appearance_begin;
    return {terravox_page_appearance_begin, static_cast<std::size_t>(size)};
}

}  // namespace terravox::page
