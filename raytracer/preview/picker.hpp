#pragma once

#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "raytracer/shade/view.hpp"
#include "raytracer/walk/walk.hpp"

namespace terravox::preview {

/// A voxel that somebody has pointed at.
struct Picked {
    core::VoxelCoord voxel;  ///< of `level`
    int level = 0;
    core::Vec3 point;  ///< where the ray meets it, level-0 voxels
    double distance_m = 0;
    bool hole = false;  ///< not a voxel: its box could not be had
    voxel::VoxelAttr attr;
};

/// What is known of a picked voxel, for a person: names and values.
struct PickedFact {
    std::string name, value;
};
[[nodiscard]] std::vector<PickedFact> facts_of(const Picked& picked, const voxel::WorldInfo& world);

/// Finds the voxel that a ray meets, on a thread of its own: a box may take seconds to come, and a
/// window shall not wait. Who asks again before the answer is there gets the answer to the last
/// question alone.
class Picker {
public:
    enum class Use : std::uint8_t { kRead, kFocus, kMeasure, kGo };
    struct Answer {
        Use use = Use::kRead;
        std::optional<Picked> picked;  ///< none: the ray leaves the world
    };

    /// @param blocks outlives the picker; its world must have been stopped before the picker goes,
    /// or the box it waits for must come
    explicit Picker(blocks::BlockManager& blocks);
    ~Picker();

    /// @param view whose levels count
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
    bool m_stop = false, m_busy = false;
    std::thread m_thread;
};

/// Straight down from above the world, at a place on the map. @param x, z level-0 voxels
[[nodiscard]] core::Ray plumb_line(const voxel::WorldInfo& world, double x, double z) noexcept;

}  // namespace terravox::preview
