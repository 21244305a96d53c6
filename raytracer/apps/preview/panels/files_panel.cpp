#include "raytracer/apps/preview/panels/panels.hpp"

#include <imgui.h>

#include <sstream>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "raytracer/apps/preview/final_render.hpp"
#include "raytracer/apps/preview/panels/form.hpp"
#include "raytracer/core/output/image_writer.hpp"
#include "raytracer/core/scene/scene_io.hpp"
#include "raytracer/core/scene/views.hpp"
#include "raytracer/farm/render/statistics.hpp"

namespace terravox::panels {
namespace {

/// File names with blanks between them.
std::vector<std::string> names_in(const std::string& text) {
    std::istringstream stream(text);
    std::vector<std::string> out;
    for (std::string name; stream >> name;)
        out.push_back(name);
    return out;
}

void file_row(const char* label, std::string& file) {
    ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x);
    if (const auto typed = widgets::text_input(label, file, 1000, "file"))
        file = typed->text;
    widgets::report_place(label);
}

}  // namespace

void FilesPanel::save_scene(preview::EditorState& editor_state) const {
    editor_state.attempt([&] {
        util::write_file_atomically(m_scene_file, scene::to_toml(editor_state.scene));
        editor_state.notify("saved " + m_scene_file);
    });
}

void FilesPanel::open_scene(preview::EditorState& editor_state, const std::string& file) {
    editor_state.attempt([&] {
        // As on the command line, so that a named view is applied.
        const scene::Scene opened = scene::compose_scene({scene::file_layer(file)});
        editor_state.take(opened);
        m_scene_file = file;
        const scene::Scene usual;
        const bool says_world = opened.world != usual.world || opened.generated != usual.generated;
        const bool other_world = says_world && (opened.world != editor_state.scene.world ||
                                                opened.generated != editor_state.scene.generated);
        editor_state.notify(
            "opened " + file +
            (other_world ? "; the world stays as it was opened, whatever the file says of it"
                         : ""));
    });
}

void FilesPanel::save_picture(preview::EditorState& editor_state,
                              const preview::Progressive& picture) const {
    editor_state.attempt([&] {
        const std::string layer = preview::collect_facts(editor_state.layer).name;
        if (!preview::has_picture(editor_state.layer))
            throw util::Error(
                "save " + m_picture_file + ": of the layer '" + layer +
                "' there is only what the window shows; allowed: the others, such as beauty");
        if (!picture.whole())
            throw util::Error("save " + m_picture_file + ": there is no whole picture yet");
        output::check_image_target(m_picture_file, picture.film()->width_px(),
                                   picture.film()->height_px());
        shade::View view = *picture.view();
        view.exposure_ev += editor_state.scene.output.exposure_ev - view.scene.output.exposure_ev;
        view.scene.output.exposure_ev = editor_state.scene.output.exposure_ev;
        view.scene.output.tone = editor_state.scene.output.tone;
        view.scene.output.credit = editor_state.scene.output.credit;
        view.scene.output.tiff = editor_state.scene.output.tiff;
        render::RenderStatistics statistics;
        statistics.counts.samples = picture.status().samples;
        output::write_image(*picture.film(), m_picture_file,
                            render::picture_info(view, editor_state.info(), statistics, false));
        editor_state.notify("saved " + m_picture_file +
                            (picture.busy() ? ", as far as it is" : "") +
                            (editor_state.layer != preview::Layer::kBeauty
                                 ? ": the picture; of the layer " + layer + " only .exr"
                                 : ""));
    });
}

void FilesPanel::start_final(preview::EditorState& editor_state,
                             preview::FinalRender& final_render) const {
    const auto files = names_in(m_final_files);
    if (files.empty())
        return editor_state.notify("render the final picture: no file named", true);
    if (final_render.runs())
        return editor_state.notify(
            "render the final picture: one is being rendered; give it up first", true);
    final_render.start(editor_state.world, editor_state.scene, files, m_render_pool);
}

std::string FilesPanel::command_line(const preview::EditorState& editor_state) const {
    std::vector<std::string> words = editor_state.world->inputs;
    for (const auto& photo : editor_state.world->orthophotos) {
        words.emplace_back("--ortho");
        words.push_back(photo.string());
    }
    const auto files = names_in(m_final_files);
    return preview::render_command_line(editor_state.scene, words,
                                        files.empty() ? "picture.png" : files.front());
}

void FilesPanel::draw(preview::EditorState& editor_state, SceneForm& form,
                      const preview::Progressive& picture, preview::FinalRender& final_render) {
    ImGui::TextDisabled("scene file");
    file_row("##scene file", m_scene_file);
    if (widgets::button("Save scene"))
        save_scene(editor_state);
    widgets::tip("Ctrl+S");
    ImGui::SameLine();
    if (widgets::button("Open scene"))
        open_scene(editor_state);
    widgets::tip("Ctrl+O, or drop the file on the window");
    ImGui::SameLine();
    if (widgets::button("Copy command")) {
        ImGui::SetClipboardText(command_line(editor_state).c_str());
        editor_state.notify("the command line is on the clipboard");
    }
    widgets::tip("renders this scene without a window (Ctrl+K)");
    ImGui::Separator();
    ImGui::TextDisabled("the picture so far");
    file_row("##picture file", m_picture_file);
    if (widgets::button("Save picture"))
        save_picture(editor_state, picture);
    widgets::tip(".png .jpg .exr .tif (Ctrl+P)");
    ImGui::Separator();
    ImGui::TextDisabled("the final picture");
    form.row("output.size");
    form.rows({"output.layers", "output.denoise", "output.credit"});
    file_row("##final files", m_final_files);
    const preview::FinalRender::Status status = final_render.status();
    const bool runs = final_render.runs();
    if (!runs) {
        if (widgets::button("Render"))
            start_final(editor_state, final_render);
        widgets::tip("in the background: the same picture as terravox render makes (Ctrl+R)");
    } else if (widgets::button("Give up")) {
        final_render.give_up();
    }
    if (runs) {
        ImGui::SameLine();
        const float share =
            status.of > 0 ? static_cast<float>(status.done) / static_cast<float>(status.of) : 0;
        ImGui::ProgressBar(share, {-1, 0});
        if (status.of == 0)
            ImGui::TextDisabled("%.0f s", status.seconds);
        else
            ImGui::TextDisabled("%llu of %llu tiles, %.0f s",
                                static_cast<unsigned long long>(status.done),
                                static_cast<unsigned long long>(status.of), status.seconds);
    }
    if (!runs && !status.message.empty())
        ImGui::TextWrapped("%s (%.1f s)", status.message.c_str(), status.seconds);
}

}  // namespace terravox::panels
