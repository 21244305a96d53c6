#include "raytracer/apps/preview/panels/panels.hpp"

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/util/error.hpp"
#include "raytracer/apps/preview/panels/form.hpp"

namespace terravox::panels {
namespace {

constexpr float kMaxOfWindow = 0.2f;  // of its width

}  // namespace

MapPanel::MapPanel(preview::EditorState& editor_state, int edge_px) {
    editor_state.attempt([&] {
        m_map = std::make_unique<preview::MiniMap>(editor_state.world->blocks, editor_state.scene,
                                                   edge_px);
    });
}

void MapPanel::draw_view(const preview::EditorState& editor_state, const shade::View* view,
                         std::array<float, 2> corner, std::array<float, 2> extent) const {
    const ImVec2 low{corner[0], corner[1]};
    const ImVec2 size{extent[0], extent[1]};
    const auto point = [&](core::Vec3 p) {
        const auto [right, down] = m_map->measure_share(p.x, p.z);
        return ImVec2{low.x + static_cast<float>(right) * size.x,
                      low.y + static_cast<float>(down) * size.y};
    };
    ImDrawList& list = *ImGui::GetWindowDrawList();
    list.PushClipRect(low, {low.x + size.x, low.y + size.y}, true);
    constexpr double kRad = std::numbers::pi / 180;
    const double half =
        view ? std::atan(std::tan(std::min(editor_state.scene.camera.fov_deg, 170.0) / 2 * kRad) *
                         view->scene.output.size_px[0] / view->scene.output.size_px[1])
             : 0;
    const double open = std::clamp(half, 2 * kRad, 85 * kRad);
    const double reach = editor_state.viewpoint.distance();
    const auto edge = [&](double turn) {
        const double h = editor_state.viewpoint.heading_deg() * kRad + turn;
        return point(editor_state.viewpoint.position +
                     core::Vec3{std::sin(h), 0, -std::cos(h)} * reach);
    };
    const ImVec2 eye = point(editor_state.viewpoint.position);
    const ImVec2 left = edge(-open);
    const ImVec2 right = edge(open);
    constexpr ImU32 kLine = IM_COL32(255, 230, 80, 220);
    // Only the rays of a perspective spread from the eye; for others the direction of view is
    // shown.
    if (view && view->camera.projection() == scene::Projection::kPerspective) {
        list.AddTriangleFilled(eye, left, right, IM_COL32(255, 230, 80, 70));
        list.AddTriangle(eye, left, right, kLine, 1.5f);
    } else {
        list.AddLine(eye, point(editor_state.viewpoint.target), kLine, 1.5f);
    }
    // An eye outside of the map is shown at its edge.
    const float font = ImGui::GetFontSize();
    const ImVec2 shown{std::clamp(eye.x, low.x, low.x + size.x),
                       std::clamp(eye.y, low.y, low.y + size.y)};
    list.AddCircleFilled(shown, font * 0.3f, IM_COL32(255, 90, 60, 255));
    list.AddCircle(point(editor_state.viewpoint.target), font * 0.3f, IM_COL32(90, 220, 255, 255),
                   0, 2);
    list.PopClipRect();
}

void MapPanel::draw(preview::EditorState& editor_state, preview::PickTool& tool,
                    const std::shared_ptr<const shade::View>& view, std::array<float, 2> corner) {
    if (!editor_state.shows_map || !m_map || m_map->version() == 0)
        return;
    const preview::ScreenPicture& screen = m_map->screen();
    if (m_map->version() != m_version)
        m_texture.set(screen, 0, screen.height_px);
    m_version = m_map->version();
    const float scale =
        std::min(1.0f, kMaxOfWindow * corner[0] /
                           static_cast<float>(std::max(screen.width_px, screen.height_px)));
    const ImVec2 size{static_cast<float>(screen.width_px) * scale,
                      static_cast<float>(screen.height_px) * scale};
    if (!(size.x >= 1) || !(size.y >= 1))
        return;  // a window without room
    ImGui::SetNextWindowPos({corner[0], corner[1]}, ImGuiCond_Always, {1, 1});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {2, 2});
    ImGui::Begin("##map", nullptr,
                 ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_AlwaysAutoResize |
                     ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoNav |
                     ImGuiWindowFlags_NoFocusOnAppearing);
    const ImVec2 low = ImGui::GetCursorScreenPos();
    // A pointer before Dear ImGui 1.91.4, a number since.
    ImGui::Image(ImTextureID(std::uintptr_t{m_texture.name()}), size);
    widgets::report_place("map");
    if (ImGui::IsItemClicked() && view) {
        const ImVec2 mouse = ImGui::GetIO().MousePos;
        const auto [x, z] = m_map->find_place(static_cast<double>((mouse.x - low.x) / size.x),
                                              static_cast<double>((mouse.y - low.y) / size.y));
        tool.go(editor_state, x, z, view);
    }
    draw_view(editor_state, view.get(), {low.x, low.y}, {size.x, size.y});
    ImGui::End();
    ImGui::PopStyleVar();
}

}  // namespace terravox::panels
