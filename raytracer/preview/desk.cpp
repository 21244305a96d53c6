#include "raytracer/preview/desk.hpp"

#include <spdlog/spdlog.h>

#include <utility>

namespace terravox {
namespace {

Scene for_a_window(Scene scene) {
    scene.camera.look.clear();         // what the view says stands in the fields
    scene.camera.inside_rock = true;   // flying through a roof must not end the preview
    scene.processing.threads.reset();  // who renders the preview is no part of the picture
    return scene;
}

}  // namespace

Desk::Desk(Scene first, std::shared_ptr<LoadedWorld> of)
    : scene(for_a_window(std::move(first))),
      opened(scene),
      world(std::move(of)),
      viewpoint(viewpoint_of(scene)),
      history(scene) {}

Viewpoint Desk::viewpoint_of(const Scene& of) const {
    const voxel::VoxelBounds& bounds = info().framed_bounds();
    const Camera camera = make_camera(of, info(), bounds);
    Viewpoint out = Viewpoint::of(camera, (bounds.min[1] + bounds.max[1]) / 2.0);
    if (of.camera.target) {
        out.target = to_voxels(*of.camera.target, of.camera.space, info());
        if (of.camera.position)
            out.position = to_voxels(*of.camera.position, of.camera.space, info());
    }
    return out;
}

void Desk::take(Scene other) {
    const Scene before = scene;
    show(std::move(other));
    history.note(before);
}

void Desk::show(Scene other) {
    other = for_a_window(std::move(other));
    other.world = opened.world, other.generated = opened.generated,
    other.processing = opened.processing;
    viewpoint = viewpoint_of(other);
    scene = std::move(other);
}

Scene Desk::placed() const {
    Scene out = scene;
    viewpoint.apply(out, info());
    return out;
}

void Desk::frame_all() {
    Scene framed = scene;
    framed.camera.position.reset(), framed.camera.target.reset(), framed.camera.height_m.reset();
    framed.camera.zoom = 1;
    take(std::move(framed));
}

void Desk::undo() {
    history.note(scene);
    show(history.undo());
}

void Desk::redo() {
    if (can_redo())
        show(history.redo());
}

void Desk::heard(std::string line) {
    said = std::move(line), said_bad = true, said_at = std::chrono::steady_clock::now();
}

void Desk::say(std::string line, bool bad) {
    spdlog::log(bad ? spdlog::level::warn : spdlog::level::info, "{}", line);
    said = std::move(line), said_bad = bad, said_at = std::chrono::steady_clock::now();
}

}  // namespace terravox
