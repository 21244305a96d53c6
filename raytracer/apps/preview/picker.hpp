#pragma once

#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "raytracer/core/shade/view.hpp"
#include "raytracer/core/walk/walk.hpp"

namespace terravox::preview {

/// A voxel that the user has picked.
struct Picked {
    core::VoxelCoord voxel;  ///< of `level`
    int level = 0;
    core::Vec3 point;  ///< where the ray hits it, level-0 voxels
    double distance_m = 0;
    bool hole = false;  ///< not a voxel: its box could not be loaded
    voxel::VoxelAttr attr;
};

/// A property of a picked voxel for display: name and value.
struct PickedFact {
    std::string name;
    std::string value;
};
[[nodiscard]] std::vector<PickedFact> facts_of(const Picked& picked, const voxel::WorldInfo& world);

/// Finds the voxel that a ray hits on a thread of its own, as loading a box may take seconds and
/// the window must not block. A new query replaces one that is not answered yet.
class Picker {
public:
    enum class Use : std::uint8_t { kRead, kFocus, kMeasure, kGo };
    struct Answer {
        Use use = Use::kRead;
        std::optional<Picked> picked;  ///< nullopt: the ray leaves the world
    };

    /// @param blocks outlives the picker; its world must be stopped before the picker is destroyed,
    /// or the destructor blocks until the box is loaded
    explicit Picker(blocks::BlockManager& blocks);
    ~Picker();

    /// @param view whose levels are used
    void ask(Use use, std::shared_ptr<const shade::View> view, const core::Ray& ray);
    [[nodiscard]] std::optional<Answer> take();
    [[nodiscard]] bool busy() const;

private:
    struct Question {
        Use use;
        std::shared_ptr<const shade::View> view;
        core::Ray ray;
    };
    void run();

    blocks::BlockManager& m_blocks;
    mutable std::mutex m_mutex;
    std::condition_variable m_wake;
    std::optional<Question> m_question;
    std::optional<Answer> m_answer;
    bool m_stop = false;
    bool m_busy = false;
    std::thread m_thread;
};

/// The ray straight down from above the world, at a point of the map.
/// @param x, z level-0 voxels
[[nodiscard]] core::Ray plumb_line(const voxel::WorldInfo& world, double x, double z) noexcept;

}  // namespace terravox::preview
