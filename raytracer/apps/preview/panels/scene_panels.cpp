#include "raytracer/apps/preview/panels/panels.hpp"

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/util/error.hpp"
#include "raytracer/apps/preview/panels/form.hpp"
#include "raytracer/core/sky/sun.hpp"

namespace terravox::panels {
namespace {

/// A legend entry, next to the last one if there is room.
void entry(const std::string& name, const ImVec4& colour) {
    const float font = ImGui::GetFontSize();
    const float width =
        font * 1.5f + ImGui::CalcTextSize(name.c_str()).x + ImGui::GetStyle().ItemSpacing.x;
    ImGui::SameLine();
    if (ImGui::GetContentRegionAvail().x < width)
        ImGui::NewLine();
    ImGui::ColorButton(name.c_str(), colour,
                       ImGuiColorEditFlags_NoTooltip | ImGuiColorEditFlags_NoInputs, {font, font});
    ImGui::SameLine(0, font / 4);
    ImGui::TextUnformatted(name.c_str());
}

void draw_materials_legend() {
    ImGui::NewLine();
    for (int i = 1; i < voxel::kMaterialCount; ++i) {
        const auto material = static_cast<voxel::Material>(i);
        const voxel::Rgb8 c = preview::colour_of_material(material);
        entry(std::string(voxel::material_name(material)),
              {c.r / 255.0f, c.g / 255.0f, c.b / 255.0f, 1});
    }
}

void draw_levels_legend(int levels) {
    ImGui::NewLine();
    for (int level = 0; level < levels; ++level) {
        const voxel::Colour c = preview::colour_of_level(level);
        entry(std::to_string(level), {c.r, c.g, c.b, 1});
    }
}

void draw_sun_hours_legend() {
    ImGui::NewLine();
    constexpr int kLongest_h = 16;
    constexpr int kStep_h = 2;
    for (int hours = 0; hours <= kLongest_h; hours += kStep_h) {
        const voxel::Colour c = preview::colour_of_sun_hours(hours);
        entry(std::to_string(hours) + " h", {c.r, c.g, c.b, 1});
    }
}

}  // namespace

void draw_light(preview::EditorState& editor_state, SceneForm& form) {
    const auto& place = editor_state.info().centre;
    const bool placed = editor_state.scene.sun.altitude_deg && editor_state.scene.sun.azimuth_deg;
    ImGui::BeginDisabled(placed);
    form.row("sun.date");
    form.row("sun.time_h", 0, 24);
    form.row("sun.zone");
    form.row("sun.utc_offset_h");
    ImGui::EndDisabled();
    try {
        const geo::SunPosition sun =
            sky::compute_sun(editor_state.scene.sun, place ? &*place : nullptr);
        ImGui::TextDisabled("sun %.1f\u00b0 high, in %.0f\u00b0", sun.altitude_deg,
                            sun.azimuth_deg);
    } catch (const util::Error& e) {
        ImGui::TextWrapped("%s", e.what());
    }
    if (place)
        ImGui::TextDisabled("at %.4f\u00b0, %.4f\u00b0", place->lat_deg, place->lon_deg);
    else
        ImGui::TextDisabled("not georeferenced: the sun of 46\u00b0 N, 14\u00b0 E");
    bool own = placed;
    if (ImGui::Checkbox("place the sun by hand", &own)) {
        if (own) {
            geo::SunPosition sun{45, 225};
            try {
                sun = sky::compute_sun(editor_state.scene.sun, place ? &*place : nullptr);
            } catch (const util::Error&) {
                // Its date is invalid: the sun is in the south-west then.
            }
            editor_state.scene.sun.altitude_deg = sun.altitude_deg;
            editor_state.scene.sun.azimuth_deg = sun.azimuth_deg;
        } else {
            editor_state.scene.sun.altitude_deg.reset();
            editor_state.scene.sun.azimuth_deg.reset();
        }
    }
    // Latitude and longitude are only valid together.
    if (placed) {
        ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x * 0.5f);
        auto altitude = static_cast<float>(*editor_state.scene.sun.altitude_deg);
        auto azimuth = static_cast<float>(*editor_state.scene.sun.azimuth_deg);
        if (ImGui::SliderFloat("altitude", &altitude, -20, 90, "%.1f\u00b0"))
            editor_state.scene.sun.altitude_deg =
                std::clamp(static_cast<double>(altitude), -90.0, 90.0);
        ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x * 0.5f);
        if (ImGui::SliderFloat("azimuth", &azimuth, 0, 360, "%.0f\u00b0"))
            editor_state.scene.sun.azimuth_deg =
                std::clamp(static_cast<double>(azimuth), -360.0, 360.0);
    }
    form.row("sun.strength", 0, 4);
    form.row("sun.size", 0, 20);
    ImGui::TextDisabled("sky");
    form.row("sky.turbidity");
    form.row("sky.visibility_km", 1, 500, 50);
    form.rows({"sky.clouds"});
    form.row("sky.cloud_height_m", 100, 6000);
    form.row("sky.strength", 0, 4);
    form.row("sky.model");
}

void draw_picture(preview::EditorState& editor_state, SceneForm& form) {
    form.row("output.exposure_ev", -6, 6);
    form.rows({"output.adaptation", "output.tone"});
    const preview::LayerFacts& facts = preview::collect_facts(editor_state.layer);
    const float width = ImGui::GetContentRegionAvail().x;
    ImGui::AlignTextToFramePadding();
    ImGui::TextUnformatted("layer");
    ImGui::SameLine(width * 0.42f);
    ImGui::SetNextItemWidth(width * 0.58f);
    if (ImGui::BeginCombo("##layer", facts.name)) {
        for (const preview::LayerFacts& l : preview::kLayers) {
            if (ImGui::Selectable(l.name, l.layer == editor_state.layer))
                editor_state.layer = l.layer;
            widgets::tip(l.doc);
        }
        ImGui::EndCombo();
    }
    widgets::tip("what of the picture is looked at (F5, F6)");
    widgets::report_place("layer");
    if (editor_state.layer != preview::Layer::kBeauty)
        ImGui::TextWrapped("%s", facts.doc);
    if (editor_state.layer == preview::Layer::kMaterial)
        draw_materials_legend();
    if (editor_state.layer == preview::Layer::kSunHours)
        draw_sun_hours_legend();
    if (editor_state.layer == preview::Layer::kLevels)
        draw_levels_legend(editor_state.info().levels);
    ImGui::AlignTextToFramePadding();
    ImGui::TextUnformatted("resolution");
    ImGui::SameLine(width * 0.42f);
    const float reset_width = ImGui::GetFrameHeight();
    ImGui::SetNextItemWidth(width * 0.58f - reset_width - ImGui::GetStyle().ItemSpacing.x);
    auto percent = static_cast<int>(editor_state.resolution * 100 + 0.5);
    if (ImGui::SliderInt("##resolution", &percent, 10, 100, "%d %%"))
        editor_state.resolution = std::clamp(percent, 10, 100) / 100.0;
    widgets::tip("pixels of the preview to those of the window, along an edge");
    ImGui::SameLine(width - reset_width);
    ImGui::PushID("resolution");
    if (widgets::reset_button(editor_state.resolution != 1))
        editor_state.resolution = 1;
    ImGui::PopID();
    ImGui::Checkbox("fill the window (F8)", &editor_state.fills);
    widgets::tip("otherwise the preview has the aspect ratio of the final picture");
}

void draw_camera(preview::EditorState& editor_state, SceneForm& form) {
    form.row("camera.projection");
    const core::CameraProjection projection = editor_state.scene.camera.projection;
    if (core::is_parallel(projection))
        form.row("camera.height_m", 1, 10'000,
                 2 * editor_state.viewpoint.distance() *
                     std::tan(editor_state.scene.camera.fov_deg / 360 * std::numbers::pi) *
                     editor_state.info().voxel_m);
    else if (projection != core::CameraProjection::kPanorama)
        form.row("camera.fov_deg", 5, projection == core::CameraProjection::kFisheye ? 360 : 120);
    form.row("camera.aperture_m", 0, 50);
    form.row("camera.focus_m", 1, 10'000,
             editor_state.viewpoint.distance() * editor_state.info().voxel_m);
    form.row("camera.roll_deg", -180, 180);
    ImGui::TextDisabled("looks to %.0f\u00b0, %.0f\u00b0 down, from %.0f m",
                        editor_state.viewpoint.heading_deg(), editor_state.viewpoint.down_deg(),
                        editor_state.viewpoint.distance() * editor_state.info().voxel_m);
    if (widgets::button("Frame all (Home)"))
        editor_state.frame_all();
    ImGui::SameLine();
    ImGui::Checkbox("fly (F)", &editor_state.fly);
    widgets::tip(
        "the mouse turns your head, and keys go where you look; else it circles what you look at");
}

void draw_materials(SceneForm& form) {
    form.rows({"quality.colour", "quality.colour_mix", "quality.textures", "quality.cut_outs",
               "quality.materials"});
}

void draw_quality(SceneForm& form) {
    form.row("quality.integrator");
    form.row("quality.samples", 1, 1024);
    form.row("quality.noise", 0, 0.2);
    form.row("quality.bounces", 0, 16);
    form.row("quality.clamp", 0, 64);
    form.rows({"quality.shadows", "quality.ambient_occlusion"});
    form.row("quality.ao_rays", 0, 64);
    form.row("quality.ao_range_m", 1, 200);
    form.rows({"quality.ao_strength", "quality.reflections", "quality.refraction"});
    form.row("quality.detail", 0, 8);
    form.row("quality.level", 0, 10);
}

void draw_tiles(SceneForm& form) {
    form.rows({"quality.tile_order", "quality.tile"});
}

}  // namespace terravox::panels
