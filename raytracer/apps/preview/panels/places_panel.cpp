#include "raytracer/apps/preview/panels/panels.hpp"

#include <imgui.h>

#include <array>
#include <charconv>
#include <cmath>

#include "common/util/error.hpp"
#include "common/util/folders.hpp"
#include "raytracer/apps/preview/panels/form.hpp"
#include "raytracer/core/scene/views.hpp"

namespace terravox::panels {
namespace {

/// The scene with the fields of a named view.
scene::Scene seen_from(const scene::NamedView& view, scene::Scene scene) {
    scene.camera.position.reset();
    scene.camera.target.reset();
    scene.camera.height_m.reset();
    scene::read_scene_table(view.fields, "go to the view " + view.name, scene);
    return scene;
}

/// Whether a view shows some of the world: its target is over it, or next to it.
bool lies_in(const scene::NamedView& view, const voxel::WorldInfo& world) {
    try {
        const scene::Scene scene = seen_from(view, scene::Scene{});
        if (!scene.camera.target)
            return false;
        const core::Vec3 at = scene::to_voxels(*scene.camera.target, scene.camera.space, world);
        const double margin = 1000 / world.voxel_m;
        return at.x > world.bounds.min[0] - margin && at.x < world.bounds.max[0] + margin &&
               at.z > world.bounds.min[2] - margin && at.z < world.bounds.max[2] + margin;
    } catch (const util::Error&) {
        return false;
    }
}

}  // namespace

std::array<double, 2> parse_place(const std::string& text, const voxel::WorldInfo& world) {
    const std::string attempt = "go to '" + text + "': ";
    const std::string allowed =
        world.crs.empty() ? "x, z in voxels"
                          : "latitude, longitude in degrees, or easting, northing in " + world.crs;
    std::array<double, 2> v{};
    const char *at = text.data(), *const end = at + text.size();
    for (std::size_t i = 0; i < 2; ++i) {
        while (at != end && (*at == ' ' || *at == ',' || *at == ';'))
            ++at;
        const auto [next, failed] = std::from_chars(at, end, v[i]);
        if (failed != std::errc{} || !std::isfinite(v[i]))
            throw util::UsageError(attempt + "not two numbers; allowed: " + allowed);
        at = next;
    }
    while (at != end && *at == ' ')
        ++at;
    if (at != end)
        throw util::UsageError(attempt + "more than two numbers; allowed: " + allowed);
    if (world.crs.empty())
        return v;
    const bool degrees = std::abs(v[0]) <= 90 && std::abs(v[1]) <= 180;
    core::Vec3 there;
    try {
        there = scene::to_voxels(
            {v[0], v[1], 0}, degrees ? core::CoordinateSpace::kLatLon : core::CoordinateSpace::kCrs,
            world);
    } catch (const util::Error&) {
        throw util::UsageError(attempt + "no place that " + world.crs +
                               " can tell; allowed: " + allowed);
    }
    if (!(std::abs(there.x) < 1e9) || !(std::abs(there.z) < 1e9))
        throw util::UsageError(attempt + "beyond 10^9 voxels; allowed: " + allowed);
    return {there.x, there.z};
}

void PlacesPanel::draw(preview::EditorState& editor_state, preview::PickTool& tool,
                       const std::shared_ptr<const shade::View>& view) {
    if (!m_views) {
        m_views.emplace();
        editor_state.attempt([&] {
            for (scene::NamedView& v : scene::read_view_folder(util::config_dir() / "views"))
                if (lies_in(v, editor_state.info()))
                    m_views->push_back(std::move(v));
        });
    }
    const auto go_to = [&](const scene::Scene& scene) {
        editor_state.attempt([&] { editor_state.take(scene); });
    };
    if (m_views->empty())
        ImGui::TextDisabled("config/views has no view of this place");
    for (const scene::NamedView& v : *m_views) {
        if (widgets::button(v.name.c_str()))
            go_to(seen_from(v, editor_state.scene));
        widgets::tip(v.title);
        const bool last = &v == &m_views->back();
        const float next = last ? 0
                                : ImGui::CalcTextSize((&v + 1)->name.c_str()).x +
                                      2 * ImGui::GetStyle().FramePadding.x;
        if (!last && ImGui::GetItemRectMax().x + ImGui::GetStyle().ItemSpacing.x + next <
                         ImGui::GetCursorScreenPos().x + ImGui::GetContentRegionAvail().x)
            ImGui::SameLine();
    }
    ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x * 0.7f);
    const auto typed = widgets::text_input(
        "##place", m_place, 100, editor_state.info().crs.empty() ? "x, z" : "lat, lon or E, N");
    widgets::report_place("place");
    if (typed)
        m_place = typed->text;
    ImGui::SameLine();
    if ((ImGui::Button("Go") || (typed && typed->entered)) && !m_place.empty() && view) {
        editor_state.attempt([&] {
            const auto [x, z] = parse_place(m_place, editor_state.info());
            tool.go(editor_state, x, z, view);
        });
    }
    ImGui::Checkbox("map", &editor_state.shows_map);
    ImGui::SameLine();
    if (ImGui::Checkbox("measure (M)", &editor_state.measures))
        tool.clear();
    widgets::tip("click on one end, then on the other");
}

}  // namespace terravox::panels
