#pragma once

#include <memory>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "common/voxel/world.hpp"
#include "voxelserver/make/worlds/overlay/footprint.hpp"

namespace terravox::overlay {

/// A planned object: solid, with walls that go straight down to the bottom of the world.
struct AddedObject {
    Footprint footprint;
    double top = 0;        ///< of its roof, level-0 voxels
    bool is_lamp = false;  ///< its highest voxels emit light
};

/// A world with planned objects in it. On every level a column of voxels belongs to an object if
/// its middle lies inside; the one in the object's middle always does, so that none vanishes but
/// lamps, which are left out where voxels are larger than 4 m. Boxes that no object touches are
/// those of the other world. Thread-safe.
class OverlayWorld final : public voxel::World {
public:
    /// @param text identifies the objects, for edition()
    OverlayWorld(std::unique_ptr<voxel::World> base, std::vector<AddedObject> objects,
                 const std::string& text);

    /// The world without the objects.
    [[nodiscard]] const voxel::World& base() const noexcept { return *m_base; }
    [[nodiscard]] const voxel::WorldInfo& info() const noexcept override { return m_info; }
    [[nodiscard]] std::shared_ptr<const voxel::Box> box(const voxel::BoxKey& key) override;
    void boxes(std::span<const voxel::BoxKey> keys, const voxel::TakeBox& take) override;
    [[nodiscard]] int preferred_batch() const noexcept override {
        return m_base->preferred_batch();
    }
    [[nodiscard]] int useful_concurrency(int threads) const noexcept override {
        return m_base->useful_concurrency(threads);
    }
    [[nodiscard]] voxel::ColumnExtent column(int level, std::int32_t bx, std::int32_t bz) override;
    [[nodiscard]] bool may_hold(const voxel::BoxRange& boxes) override;
    [[nodiscard]] std::vector<std::string> damage() const override { return m_base->damage(); }
    [[nodiscard]] std::string edition() const override;
    void stop() noexcept override { m_base->stop(); }

private:
    using Objects = std::vector<const AddedObject*>;
    /// Those whose bounds meet columns of boxes, [bx, end_bx) x [bz, end_bz).
    [[nodiscard]] Objects objects_within(int level, std::int32_t bx, std::int32_t bz,
                                         std::int32_t end_bx, std::int32_t end_bz) const;
    [[nodiscard]] Objects objects_at(int level, std::int32_t bx, std::int32_t bz) const {
        return objects_within(level, bx, bz, bx + 1, bz + 1);
    }
    [[nodiscard]] std::shared_ptr<const voxel::Box> with_objects(
        const voxel::BoxKey& key, std::shared_ptr<const voxel::Box> base) const;

    const std::unique_ptr<voxel::World> m_base;
    const std::vector<AddedObject> m_objects;
    const std::string m_text;
    voxel::WorldInfo m_info;
};

/// What a column of level 0 shows from above, apart from plants.
struct Surface {
    std::int32_t top = 0;    ///< of its highest voxel, voxels
    bool is_ground = false;  ///< terrain or water, on which nothing opaque stands, such as a house
};

/// @return nullopt for a column of air
/// @throws Error as World::box()
[[nodiscard]] std::optional<Surface> find_surface(voxel::World& world, std::int32_t x,
                                                  std::int32_t z);

/// Height of the ground at a column of level 0, voxels: below a building, which voxels do not tell,
/// the median of the nearest ground in eight directions, up to 128 voxels away; where there is none
/// either, the top of what is there.
/// @return nullopt for a column of air
/// @throws Error as World::box()
[[nodiscard]] std::optional<std::int32_t> find_ground(voxel::World& world, std::int32_t x,
                                                      std::int32_t z);

/// The forms of an addition, for help and messages.
inline constexpr const char* kAdditionForms =
    "west,south,east,north,TOP (height of its top, metres), west,south,east,north,+HEIGHT (above "
    "the ground in its middle), or a GeoJSON file of polygons with the property top or height, and "
    "of points, which become street lamps";
inline constexpr std::size_t kMaxObjects = 10'000;
/// Height of a street lamp that has neither property.
inline constexpr double kLampHeight_m = 5;

/// Puts planned objects into a world.
/// @param additions each one of kAdditionForms; coordinates in the world's CRS, in voxels x0,z0,
/// x1,z1 where it has none; none: the world is returned as it is
/// @throws UsageError for another text, for objects outside of the world or without a height;
/// Error for a file that cannot be read, and as World::box(); "interrupted" when stopped
[[nodiscard]] std::unique_ptr<voxel::World> with_additions(std::unique_ptr<voxel::World> world,
                                                           std::span<const std::string> additions,
                                                           const std::stop_token& stop = {});

}  // namespace terravox::overlay
