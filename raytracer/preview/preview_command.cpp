#include "raytracer/preview/preview_command.hpp"

#include <CLI/CLI.hpp>
#include <imgui.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <memory>
#include <optional>

#include "common/util/cache_dir.hpp"
#include "common/thread/parallel.hpp"
#include "common/util/atomic_file.hpp"
#include "common/util/log.hpp"
#include "common/util/stage_times.hpp"
#include "raytracer/preview/orbit.hpp"
#include "raytracer/preview/progressive.hpp"
#include "raytracer/preview/window.hpp"
#include "raytracer/render/world_arguments.hpp"
#include "raytracer/scene/scene_io.hpp"
#include "raytracer/world/open_world.hpp"

namespace terravox {
namespace {

struct Arguments {
    WorldArguments world;
    std::string save_scene = "preview-scene.toml";
};

/// What dragging and keys do to the orbit. @return something moved
bool move_camera(Orbit& orbit) {
    const ImGuiIO& io = ImGui::GetIO();
    const Orbit before = orbit;
    if (!io.WantCaptureMouse) {
        constexpr double kDegreesPerPixel = 0.25;
        if (ImGui::IsMouseDragging(ImGuiMouseButton_Left, 0)) orbit.turn(io.MouseDelta.x * kDegreesPerPixel, io.MouseDelta.y * kDegreesPerPixel);
        if (ImGui::IsMouseDragging(ImGuiMouseButton_Right, 0)) orbit.pan(-io.MouseDelta.x / io.DisplaySize.y, io.MouseDelta.y / io.DisplaySize.y);
        if (io.MouseWheel != 0) orbit.zoom(std::pow(0.9, io.MouseWheel));
    }
    if (!io.WantCaptureKeyboard) {
        const double step = 0.9 * io.DeltaTime;
        const auto held = [&](char key) { return io.KeysDown[static_cast<int>(key)] ? 1.0 : 0.0; };
        orbit.pan((held('D') - held('A')) * step, (held('W') - held('S')) * step);
        if (held('Q') != held('E')) orbit.zoom(1 + (held('Q') - held('E')) * step);
    }
    return before.azimuth_deg != orbit.azimuth_deg || before.down_deg != orbit.down_deg || before.distance != orbit.distance ||
           length(before.target - orbit.target) > 0;
}

bool slider(const char* label, double& value, double low, double high, const char* format) {
    auto v = static_cast<float>(value);
    if (!ImGui::SliderFloat(label, &v, static_cast<float>(low), static_cast<float>(high), format)) return false;
    value = v;
    return true;
}

/// The panel. @return the scene changed
bool panel(Scene& scene, const Progressive& picture, const std::string& problem, bool& save) {
    bool changed = false;
    ImGui::SetNextWindowPos({10, 10}, ImGuiCond_FirstUseEver);
    ImGui::Begin("Terravox", nullptr, ImGuiWindowFlags_AlwaysAutoResize);
    ImGui::PushItemWidth(180);
    changed |= slider("time, h", scene.sun.time_h, 0, 24, "%.2f");
    changed |= slider("exposure, stops", scene.output.exposure_ev, -4, 4, "%.2f");
    changed |= slider("field of view, deg", scene.camera.fov_deg, 5, 120, "%.0f");
    changed |= slider("turbidity of the air", scene.sky.turbidity, 1.5, 10, "%.1f");
    changed |= ImGui::SliderInt("samples", &scene.quality.samples, 1, 16);
    changed |= ImGui::Checkbox("shadows", &scene.quality.shadows);
    ImGui::SameLine();
    changed |= ImGui::Checkbox("corners", &scene.quality.ambient_occlusion);
    ImGui::SameLine();
    changed |= ImGui::Checkbox("mirrors", &scene.quality.reflections);
    save = ImGui::Button("Save scene");
    const auto status = picture.status();
    const double share = status.tiles_total > 0 ? static_cast<double>(status.tiles_done) / static_cast<double>(status.tiles_total) : 0;
    ImGui::ProgressBar(static_cast<float>(share), {180, 0});
    ImGui::Text("%.1f Mray/s", status.seconds > 0 ? static_cast<double>(status.rays) / 1e6 / status.seconds : 0.0);
    if (!problem.empty()) ImGui::TextWrapped("%s", problem.c_str());
    ImGui::TextDisabled("left drag: turn   right drag, WASD: move\nwheel, Q E: nearer, farther   Esc: quit");
    ImGui::PopItemWidth();
    ImGui::End();
    return changed;
}

ExitCode run(const Arguments& args) {
    util::set_up_log(args.world.log_level);
    Scene scene = args.world.scene();
    scene.camera.inside_rock = true;  // flying through a roof must not end the preview
    Window window(scene.output.size_px[0], scene.output.size_px[1], "Terravox");
    util::StageTimes times;
    const auto world = open_world(args.world.inputs, args.world.orthophoto_paths(), scene, times, util::cache_dir(args.world.cache));
    BlockManager blocks(*world, static_cast<std::size_t>(scene.processing.memory_mib) << 20,
                        world->worth_asking(thread::thread_count(scene.processing.threads.value_or(0))));
    const auto& bounds = world->info().framed_bounds();
    Orbit orbit = Orbit::from(make_camera(scene, world->info(), bounds), (bounds.min[1] + bounds.max[1]) / 2.0);
    orbit.apply(scene);
    Progressive picture(blocks, thread::thread_count(scene.processing.threads.value_or(0)));
    std::vector<std::uint8_t> rgb;
    std::uint64_t seen = 0;
    std::string problem;
    bool restart = true;
    while (window.open()) {
        window.begin_frame(picture.status().finished ? 0.1 : 0.016);
        bool save = false;
        restart |= panel(scene, picture, problem, save);
        if (move_camera(orbit)) orbit.apply(scene), restart = true;
        if (const auto [width, height] = window.size_px(); width > 0 && height > 0 && (width != scene.output.size_px[0] || height != scene.output.size_px[1]))
            scene.output.size_px = {width, height}, restart = true;
        constexpr int kEscape = 256;  // GLFW_KEY_ESCAPE
        if (ImGui::GetIO().KeysDown[kEscape]) window.close();
        try {
            if (save) {
                util::write_file_atomically(args.save_scene, to_toml(scene));
                problem = "saved " + args.save_scene;
            }
            if (restart) picture.start(scene);
            picture.check();
        } catch (const Error& e) {
            problem = e.what();
        }
        restart = false;
        int width = 0, height = 0;
        if (picture.copy_if_new(rgb, width, height, seen)) window.set_picture(rgb, width, height);
        window.end_frame();
    }
    picture.stop();
    return blocks.hole_count() > 0 ? ExitCode::kHoles : ExitCode::kDone;
}

}  // namespace

std::function<ExitCode()> add_preview_command(CLI::App& app) {
    auto args = std::make_shared<Arguments>();
    CLI::App* command = app.add_subcommand("preview", "Fly around a world in a window while it is rendered, coarse to fine");
    add_world_arguments(*command, args->world);
    command->add_option("--save-scene", args->save_scene, "where the panel's button saves the scene")->capture_default_str();
    return [args] { return run(*args); };
}

}  // namespace terravox
