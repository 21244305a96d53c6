#include "raytracer/apps/preview/opening.hpp"

#include <utility>

#include "common/util/error.hpp"

namespace terravox::preview {

Opening::Opening(worlds::WorldOptions from, const scene::Scene& scene)
    : m_thread([this, from = std::move(from), scene](const std::stop_token& stop) {
          std::shared_ptr<render::LoadedWorld> world;
          std::string failure;
          try {
              world = std::make_shared<render::LoadedWorld>(from, scene, stop);
              if (world->world->info().bounds.empty())
                  throw util::Error("show the world '" + world->world->info().title +
                                    "': it is empty");
          } catch (const std::exception& e) {
              world.reset();
              failure = e.what();
          }
          const std::lock_guard lock(m_mutex);
          m_world = std::move(world);
          m_failure = std::move(failure);
          m_done = true;
      }) {}

Opening::~Opening() {
    m_thread.request_stop();
    m_thread.join();
}

std::shared_ptr<render::LoadedWorld> Opening::take() {
    const std::lock_guard lock(m_mutex);
    return std::exchange(m_world, nullptr);
}

std::string Opening::failure() const {
    const std::lock_guard lock(m_mutex);
    return m_failure;
}

bool Opening::runs() const {
    const std::lock_guard lock(m_mutex);
    return !m_done;
}

}  // namespace terravox::preview
