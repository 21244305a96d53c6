#include "raytracer/apps/preview/screen_developer.hpp"

#include <algorithm>

namespace terravox::preview {

RowRange ScreenDeveloper::update(Progressive& picture, const scene::Scene::Output& output,
                                 Layer layer) {
    // After a scene that cannot be rendered, the film is that of the previous picture.
    const output::Film* const film = picture.film();
    if (film == nullptr || film->width_px() != m_screen.width_px ||
        film->height_px() != m_screen.height_px)
        return {};
    auto changes = picture.take_changes();
    m_develops_all |= m_output.exposure_ev != output.exposure_ev || m_output.tone != output.tone;
    m_output = output;
    if (m_develops_all && picture.whole()) {
        tiles::RenderTile all;
        all.x1 = m_screen.width_px;
        all.y1 = m_screen.height_px;
        changes = {all};
        m_develops_all = false;
    }
    RowRange rows{m_screen.height_px, 0};
    for (const tiles::RenderTile& tile : changes) {
        show(*film, *picture.view(), output, layer, tile, m_screen);
        rows.first = std::min(rows.first, tile.y0);
        rows.end = std::max(rows.end, std::min(tile.y1 + tile.step, m_screen.height_px));
    }
    return rows;
}

}  // namespace terravox::preview
