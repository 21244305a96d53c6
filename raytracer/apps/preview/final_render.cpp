#include "raytracer/apps/preview/final_render.hpp"

#include <sys/resource.h>
#include <utility>

#include "common/thread/start_threads.hpp"
#include "common/util/error.hpp"
#include "common/util/text.hpp"
#include "raytracer/core/scene/scene_io.hpp"

namespace terravox::preview {

std::string render_command_line(const scene::Scene& scene, const std::vector<std::string>& world,
                                const std::string& picture) {
    std::string out = "terravox render";
    const auto add = [&](const std::string& word) { out += " " + util::shell_word(word); };
    for (const std::string& word : world)
        add(word);
    // Option and value form one word, as negative numbers would be parsed as flags.
    for (const scene::FieldText& field : scene::changed_fields(scene, scene::Scene{}))
        if (field.text)
            out += " " + scene::find_flag(field.path) + "=" + util::shell_word(*field.text);
    add("-o");
    add(picture);
    return out;
}

namespace {

constexpr int kGivesWay = 10;  // nice value: the window's threads have priority

}  // namespace

void FinalRender::start(std::shared_ptr<render::LoadedWorld> world, const scene::Scene& scene,
                        std::vector<std::string> files,
                        const render::RenderPoolOptions& render_pool) {
    stop();
    m_stop = std::stop_source();
    m_start = std::chrono::steady_clock::now();
    {
        const std::lock_guard lock(m_mutex);
        m_status = {};
        m_status.state = State::kRunning;
    }
    try {
        m_thread = thread::start_thread(
            "the picture", [this, world = std::move(world), scene, files = std::move(files),
                            render_pool] { run(world, scene, files, render_pool); });
    } catch (const util::Error& e) {
        const std::lock_guard lock(m_mutex);
        m_status.state = State::kFailed;
        m_status.message = e.what();
    }
}

void FinalRender::stop() noexcept {
    m_stop.request_stop();
    if (m_thread.joinable())
        m_thread.join();
}

void FinalRender::run(const std::shared_ptr<render::LoadedWorld>& world, const scene::Scene& scene,
                      const std::vector<std::string>& files,
                      const render::RenderPoolOptions& render_pool) {
    // The nice value of this thread and those that it starts.
    (void)::setpriority(PRIO_PROCESS, 0, kGivesWay);
    State state = State::kDone;
    std::string message;
    try {
        render::PictureRenderer::check(scene, files);
        render::PictureRenderer renderer(world, render_pool, scene, true, m_stop.get_token());
        renderer.on_progress([this](std::uint64_t done, std::uint64_t of) {
            const std::lock_guard lock(m_mutex);
            m_status.done = done;
            m_status.of = of;
        });
        const render::RenderStatistics statistics = renderer.render(scene, files);
        message = "wrote";
        for (const std::string& file : files)
            message += " " + file;
        if (!statistics.counts.holes.empty())
            message += "; it has holes: " + std::to_string(statistics.counts.holes.size()) +
                       " boxes could not be loaded";
    } catch (const std::exception& e) {
        state = State::kFailed;
        message = m_stop.stop_requested() ? kGivenUp : e.what();
    }
    const std::lock_guard lock(m_mutex);
    m_status.state = state;
    m_status.message = std::move(message);
    m_status.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - m_start).count();
}

FinalRender::Status FinalRender::status() const {
    const std::lock_guard lock(m_mutex);
    Status out = m_status;
    if (out.state == State::kRunning)
        out.seconds =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - m_start).count();
    return out;
}

}  // namespace terravox::preview
