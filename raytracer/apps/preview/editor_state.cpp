#include "raytracer/apps/preview/editor_state.hpp"

#include <utility>

#include "common/util/log.hpp"

namespace terravox::preview {

void SceneHistory::note(const scene::Scene& scene) {
    if (scene == m_scenes[m_at])
        return;
    m_scenes.resize(m_at + 1);
    m_scenes.push_back(scene);
    if (m_scenes.size() > kMax)
        m_scenes.erase(m_scenes.begin());
    m_at = m_scenes.size() - 1;
}

void HistoryRecorder::update(SceneHistory& history, const scene::Scene& scene, bool busy,
                             Clock::time_point now) {
    if (busy || m_last != scene) {
        m_settled = now;
        m_last = scene;
    }
    if (!busy && now - m_settled > kSettled)
        history.note(scene);
}

namespace {

scene::Scene for_a_window(scene::Scene scene) {
    scene.camera.look.clear();         // the named view is expanded into the fields
    scene.camera.inside_rock = true;   // flying through a roof must not end the preview
    scene.processing.threads.reset();  // the preview's processors are not part of the picture
    return scene;
}

}  // namespace

EditorState::EditorState(scene::Scene first, std::shared_ptr<render::LoadedWorld> of)
    : scene(for_a_window(std::move(first))),
      opened(scene),
      world(std::move(of)),
      viewpoint(to_viewpoint(scene)),
      history(scene) {}

Viewpoint EditorState::to_viewpoint(const scene::Scene& of) const {
    const voxel::VoxelBounds bounds = info().camera_bounds();
    const scene::Camera camera = scene::make_camera(of, info(), bounds);
    Viewpoint out = Viewpoint::of(camera, (bounds.min[1] + bounds.max[1]) / 2.0);
    if (of.camera.target) {
        out.target = scene::to_voxels(*of.camera.target, of.camera.space, info());
        if (of.camera.position)
            out.position = scene::to_voxels(*of.camera.position, of.camera.space, info());
    }
    return out;
}

void EditorState::take(scene::Scene other) {
    const scene::Scene before = scene;
    show(std::move(other));
    history.note(before);
}

void EditorState::show(scene::Scene other) {
    other = for_a_window(std::move(other));
    other.world = opened.world;
    other.generated = opened.generated;
    other.processing = opened.processing;
    viewpoint = to_viewpoint(other);
    scene = std::move(other);
}

scene::Scene EditorState::placed() const {
    scene::Scene out = scene;
    viewpoint.apply(out, info());
    return out;
}

void EditorState::frame_all() {
    scene::Scene framed = scene;
    framed.camera.position.reset();
    framed.camera.target.reset();
    framed.camera.height_m.reset();
    framed.camera.zoom = 1;
    take(std::move(framed));
}

void EditorState::undo() {
    history.note(scene);
    show(history.undo());
}

void EditorState::redo() {
    if (can_redo())
        show(history.redo());
}

void EditorState::show_logged(std::string line) {
    notice = std::move(line);
    notice_is_bad = true;
    noticed_at = std::chrono::steady_clock::now();
}

void EditorState::notify(std::string line, bool bad) {
    util::log_message(bad ? util::LogLevel::kWarning : util::LogLevel::kInfo, "{}", line);
    notice = std::move(line);
    notice_is_bad = bad;
    noticed_at = std::chrono::steady_clock::now();
}

}  // namespace terravox::preview
