#pragma once

#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "voxelserver/data/pointcloud/point_source.hpp"
#include "voxelserver/make/voxelize/points/brightness.hpp"
#include "voxelserver/make/voxelize/points/class_table.hpp"
#include "voxelserver/make/voxelize/points/extent.hpp"
#include "voxelserver/make/voxelize/points/settings.hpp"

namespace terravox::voxelize {

/// What opening finds out about a point file by reading its header and a sample of its points.
/// Plain data.
struct KnownSquare {
    voxel::Fingerprint identity{};       ///< common/voxel/fingerprint.hpp
    voxel::Fingerprint side_identity{};  ///< of its side file; zeros: it has none
    pointcloud::PointCloudInfo stated;   ///< as the file states it; the path is not kept

    // From here on with the CRS in which the file was placed, which options may have set.
    std::string crs_wkt;
    std::array<double, 3> min{};  ///< that hold all points (extent.hpp)
    std::array<double, 3> max{};
    std::vector<PlanRect> islands;
    double low = 0;  ///< heights that nearly all points keep, file units
    double high = 0;
    bool has_water = false;
    bool has_colour = false;
    int colour_shift = 0;
    bool has_index = false;           ///< a spatial index, where the file could use one
    bool has_echoes = false;          ///< of ground without colours, with an intensity
    voxel::Fingerprint scale_from{};  ///< of all files whose echoes have a part in the scale
    BrightnessScale brightness;
    grid::ColumnRect bounds;  ///< in columns of the world that it was opened for
};

/// What is known of the files of a world, so that they need not be read again: by their identities,
/// so a file that has changed is not known. const functions may be called concurrently.
class KnownSquares {
public:
    /// @return the one that was added first; nullptr when the file is not known
    [[nodiscard]] const KnownSquare* find(const voxel::Fingerprint& identity,
                                          const voxel::Fingerprint& side_identity) const;
    /// Whatever its side file.
    [[nodiscard]] const KnownSquare* find(const voxel::Fingerprint& identity) const;
    /// @param identity as voxel::to_hex() writes it; others are not known
    [[nodiscard]] const KnownSquare* find(std::string_view identity) const;
    void add(KnownSquare square);
    [[nodiscard]] bool empty() const noexcept { return m_squares.empty(); }

    voxel::Fingerprint roles{};  ///< fingerprint_of_roles() that what is known depends on

    /// With a checksum, the same on every machine. Squares whose CRS does not survive being written
    /// as WKT are left out.
    /// @param way way_of_opening()
    [[nodiscard]] std::string to_bytes(const voxel::Fingerprint& way) const;
    /// @param bytes from any source
    /// @throws Error for bytes that are damaged, of another version, or of another way of opening
    [[nodiscard]] static KnownSquares from_bytes(std::string_view bytes,
                                                 const voxel::Fingerprint& way);

private:
    template <class Wanted>
    [[nodiscard]] const KnownSquare* first(const voxel::Fingerprint& identity,
                                           const Wanted& wanted) const;

    std::vector<KnownSquare> m_squares;
    std::unordered_multimap<std::uint64_t, std::size_t> m_by_identity;
};

/// Of all that what is found depends on, apart from the files and what their classes mean: version
/// of the program, and filters.
[[nodiscard]] voxel::Fingerprint way_of_opening(const Settings::Points& filters);

/// Of what each class does.
[[nodiscard]] voxel::Fingerprint fingerprint_of_roles(const ClassTable& classes);

}  // namespace terravox::voxelize
