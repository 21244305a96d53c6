#include "raytracer/apps/preview/notices.hpp"

#include "common/voxel/world.hpp"

namespace terravox::preview {

std::vector<Notice> Notices::take(const blocks::BlockManager& blocks,
                                  const FinalRender::Status& final_render) {
    std::vector<Notice> out;
    if (std::string line = m_log ? m_log->take() : ""; !line.empty())
        out.push_back({std::move(line), true, true});
    try {
        if (!m_world_changed)
            blocks.check_world();
    } catch (const voxel::ChangedError& e) {
        m_world_changed = true;
        out.push_back({e.what(), true, false});
    }
    const bool runs = final_render.state == FinalRender::State::kRunning;
    if (std::exchange(m_final_ran, runs) && !runs) {
        const bool failed = final_render.state == FinalRender::State::kFailed &&
                            final_render.message != FinalRender::kGivenUp;
        out.push_back({"the final picture: " + final_render.message, failed, false});
    }
    return out;
}

}  // namespace terravox::preview
