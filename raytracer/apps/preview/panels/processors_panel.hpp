#pragma once

#include <chrono>
#include <map>
#include <string>
#include <vector>

#include "raytracer/apps/preview/editor_state.hpp"
#include "raytracer/farm/render/render_pool.hpp"

namespace terravox::panels {

/// The processors that render the preview: shows their state, adds and removes them.
class ProcessorsPanel {
public:
    void draw(preview::EditorState& editor_state, render::RenderPool& render_pool);

private:
    struct Speed {
        std::uint64_t tiles = 0;  ///< at the last update
        double tiles_per_s = 0;   ///< moving average
    };
    void update(const render::RenderPool& render_pool);
    void note_speeds(double passed_s);
    void draw_local(render::RenderPool& render_pool) const;
    void draw_workers(preview::EditorState& editor_state, render::RenderPool& render_pool);
    void draw_participants();
    std::string m_address;
    std::vector<render::RenderPool::Participant> m_participants;
    std::map<processors::ProcessorPool::MemberId, Speed> m_speeds;
    std::vector<std::string> m_dialled;
    std::chrono::steady_clock::time_point m_updated;
};

}  // namespace terravox::panels
