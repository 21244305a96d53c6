#pragma once

#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>

#include "raytracer/core/scene/scene.hpp"
#include "raytracer/farm/render/loaded_world.hpp"
#include "voxelserver/make/worlds/kind/world_options.hpp"

namespace terravox::preview {

/// Opens a world on a thread of its own, as that may take minutes.
class Opening {
public:
    Opening(worlds::WorldOptions from, const scene::Scene& scene);
    ~Opening();  ///< cancels the opening; a world of files is opened to the end first

    /// @return the world, once; nullptr while it is being opened, and if that failed
    [[nodiscard]] std::shared_ptr<render::LoadedWorld> take();
    /// Why the world could not be opened; empty: it is being opened, or is open.
    [[nodiscard]] std::string failure() const;
    [[nodiscard]] bool runs() const;  ///< whether it is neither open nor failed

private:
    mutable std::mutex m_mutex;
    std::shared_ptr<render::LoadedWorld> m_world;
    std::string m_failure;
    bool m_done = false;
    std::jthread m_thread;
};

}  // namespace terravox::preview
