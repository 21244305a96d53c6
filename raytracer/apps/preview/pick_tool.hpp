#pragma once

#include <array>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "raytracer/apps/preview/editor_state.hpp"
#include "raytracer/apps/preview/navigator.hpp"
#include "raytracer/apps/preview/pane.hpp"
#include "raytracer/core/shade/view.hpp"

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
[[nodiscard]] std::vector<PickedFact> collect_facts(const Picked& picked,
                                                    const voxel::WorldInfo& world);

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

/// A distance between two voxels.
struct Measured {
    double level_m = 0;   ///< horizontal distance
    double height_m = 0;  ///< of the second voxel minus that of the first
    double length_m = 0;  ///< straight-line distance
    double heading_deg = 0;
};
[[nodiscard]] Measured measure(const Picked& from, const Picked& to, double voxel_m) noexcept;

/// The ray through a point of the window.
/// @param x, y pixels of the window
/// @return nullopt outside the pane, and where the camera shows nothing
[[nodiscard]] std::optional<core::Ray> ray_through(const scene::Camera& camera,
                                                   std::array<int, 2> picture_px, const Pane& pane,
                                                   double x, double y) noexcept;

/// Handles clicks on the picture: inspect a voxel, aim the camera at it, measure between two.
class PickTool {
public:
    explicit PickTool(blocks::BlockManager& blocks) : m_picker(blocks) {}

    /// @param pane that shows the picture
    /// @param view of the picture that is shown; nullptr: there is none yet
    void click(const EditorState& editor_state, const Navigator::Click& click, const Pane& pane,
               const std::shared_ptr<const shade::View>& view);
    /// Finds the ground at a point of the map, and moves the viewpoint there in update().
    /// @param x, z level-0 voxels
    void go(const EditorState& editor_state, double x, double z,
            const std::shared_ptr<const shade::View>& view);
    /// Handles the results of clicks.
    /// @return whether the viewpoint has moved
    bool update(EditorState& editor_state);
    [[nodiscard]] bool busy() const { return m_picker.busy(); }
    void clear() noexcept {
        m_read.reset();
        m_first.reset();
        m_second.reset();
    }
    /// Draws its window, and marks over the picture.
    void draw(EditorState& editor_state, const shade::View& view, const Pane& pane,
              std::array<int, 2> window_px);

private:
    void draw_marks(const shade::View& view, const Pane& pane) const;
    void draw_distance(const voxel::WorldInfo& world) const;
    void draw_facts(EditorState& editor_state) const;

    Picker m_picker;
    std::optional<Picked> m_read;
    std::optional<Picked> m_first;
    std::optional<Picked> m_second;
    std::vector<PickedFact> m_facts;  ///< facts of m_read
    core::Vec3 m_go;                  ///< target of go(), where there may be no ground
};

}  // namespace terravox::preview
