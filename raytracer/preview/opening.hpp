#pragma once

#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>

#include "raytracer/render/loaded_world.hpp"
#include "raytracer/scene/scene.hpp"
#include "voxelserver/worlds/kind/world_options.hpp"

namespace terravox::preview {

/// A world that is being opened, on a thread of its own: that may take minutes.
class Opening {
public:
    Opening(worlds::WorldOptions from, const scene::Scene& scene);
    ~Opening();  ///< gives it up; a world of files is opened to its end first

    /// @return the world, once; nullptr while it is being opened, and when it could not be
    [[nodiscard]] std::shared_ptr<render::LoadedWorld> take();
    /// Why it could not be opened; empty: it is being opened still, or is open.
    [[nodiscard]] std::string failure() const;
    [[nodiscard]] bool runs() const;  ///< neither open nor failed

private:
    mutable std::mutex m_mutex;
    std::shared_ptr<render::LoadedWorld> m_world;
    std::string m_failure;
    bool m_done = false;
    std::jthread m_thread;
};

}  // namespace terravox::preview
