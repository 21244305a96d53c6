#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "raytracer/analyse/evaluators/cell_evaluator.hpp"
#include "raytracer/core/base/analysis_bands.hpp"
#include "raytracer/core/base/ray.hpp"
#include "raytracer/core/shade/shading.hpp"

namespace terravox::analyse {

/// Sums over the heights of a cell and of its neighbours, for the plane through them. Heights are
/// relative to the cell's and whole voxels, so the sums do not depend on the order.
struct HeightSums {
    float count = 0;
    float e = 0, s = 0, h = 0;  ///< steps to the east and to the south, height in voxels
    float ee = 0, es = 0, ss = 0, eh = 0, sh = 0, hh = 0;

    /// @param east, south steps of a cell
    /// @param height level-0 voxels above the cell
    void add(int east, int south, float height) noexcept;
};

/// Whether a neighbour belongs to the surface of a cell: what rises or falls more steeply than a
/// steep roof is another surface, such as a wall or the ground below the eaves.
/// @param distance to the neighbour, level-0 voxels
/// @param height of it above the cell, level-0 voxels
/// @param step edge of the voxels that heights are in, level-0 voxels
[[nodiscard]] bool is_same_surface(double distance, double height, double step) noexcept;

/// The surface of a cell as a plane.
struct CellPlane {
    double east = 0;   ///< rise per distance to the east
    double south = 0;  ///< rise per distance to the south
    /// How far above the cell's top a point lies that sees over the steps of the voxels along the
    /// plane, level-0 voxels; 0 on level ground.
    double lift = 0;

    [[nodiscard]] core::Vec3 normal() const noexcept;
};

/// The direction in which something looks, degrees clockwise from the map's north, [0, 360).
/// @param normal x east, z south; not vertical
[[nodiscard]] double azimuth_deg(core::Vec3 normal) noexcept;

/// The plane of least squares. Heights in one line, or fewer than three, give a level one.
/// @param spacing of the cells, level-0 voxels
/// @param step as above
[[nodiscard]] CellPlane plane_through(const HeightSums& sums, double spacing, double step) noexcept;

/// Gathers the light of a period on a plane, by a ray in each direction of the view's light from
/// one point. Whatever blocks a ray blocks all of its direction's light, but crowns, which let a
/// share of it through, whatever their thickness.
///
/// What is known while rays are on their way is kept in the bands of the cell. Band 0 counts holes
/// and stays what it is.
class PlaneLight {
public:
    /// What counts for light from behind the plane, which only the surroundings reflect.
    enum class Behind : std::uint8_t {
        kSeen,  ///< what rays find there, past what the plane belongs to
        kFree,  ///< no ray is sent: the surroundings in front are lit as in the open
    };

    PlaneLight(const shade::View& view, const Sunlight& sunlight, Behind behind) noexcept;

    /// The directions of fans of a stream, for the evaluator that they belong to.
    [[nodiscard]] walk::FanDirections directions(std::uint32_t stream) const noexcept;

    /// Begins, and sends the first rays. What the bands held before is lost.
    /// @param normal of unit length, y >= 0; x east, y up, z south
    /// @param kept a number that result() gives back
    /// @param start of start_at(): fans that follow rays through crowns find its voxel again
    /// @return whether that was all: there is no direction to look into
    [[nodiscard]] bool begin(core::Vec3 normal, float kept, const FanStart& start,
                             shade::SampleSum& sum, std::vector<walk::TracedRay>& next) const;
    /// Takes a fan at its end, none of whose rays has met a hole.
    /// @param evaluator whose fan it is
    /// @return whether that was all
    [[nodiscard]] bool take_fan(const walk::TracedRay& fan, walk::FanEnds ends,
                                const shade::RayEvaluator& evaluator, shade::SampleSum& sum,
                                std::vector<walk::TracedRay>& next) const;
    /// Takes a ray through crowns at its end, which has met no hole.
    /// @return whether that was all
    [[nodiscard]] bool take_through_crowns(const walk::TracedRay& ray, shade::SampleSum& sum,
                                           std::vector<walk::TracedRay>& next) const;

    /// Light on the plane, kWh/m2.
    struct Result {
        double beam = 0;
        double diffuse = 0;
        double reflected = 0;
        double sky_view = 0;  ///< share of the light of an even sky, [0, 1]
        float sun_hours = 0;
        core::Vec3 normal;
        float kept = 0;
        [[nodiscard]] double total() const noexcept { return beam + diffuse + reflected; }
    };
    /// @param bands of a cell whose light is complete
    [[nodiscard]] Result result(const core::Bands& bands) const noexcept;
    /// Place of the number given to begin() among the bands, from begin() on.
    static constexpr std::size_t kKept = core::kMaxBands - 1;

private:
    /// Sends fans from direction `first` on, until there is one that has rays.
    [[nodiscard]] bool send(const FanStart& start, std::size_t first, shade::SampleSum& sum,
                            std::vector<walk::TracedRay>& next) const;
    [[nodiscard]] std::size_t count() const noexcept;
    [[nodiscard]] core::Vec3 direction(std::size_t index) const noexcept;
    /// Sends a ray of a fan once more from where it came, through crowns: what has blocked it is
    /// not known.
    void send_through_crowns(const walk::TracedRay& fan, std::size_t index,
                             std::vector<walk::TracedRay>& next) const;
    /// Sends a blocked ray on through crowns.
    /// @return false: what has blocked it lets no light through
    [[nodiscard]] bool goes_on_through_crowns(const walk::TracedRay& ray,
                                              std::vector<walk::TracedRay>& next) const;

    /// Whether light that meets a material on its way through crowns goes on.
    [[nodiscard]] bool lets_through(voxel::Material material) const noexcept;

    const Sunlight& m_sunlight;
    const double m_albedo;  ///< of the surroundings
    const Behind m_behind;
    const bool m_crowns_shine;  ///< blocked rays are sent once more, through crowns
    const bool m_thin_passes;   ///< things of core::is_thin() end no ray on its way through crowns
};

}  // namespace terravox::analyse
