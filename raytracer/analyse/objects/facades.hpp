#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <stop_token>
#include <vector>

#include "raytracer/analyse/objects/object_sums.hpp"
#include "raytracer/analyse/objects/objects.hpp"
#include "raytracer/analyse/raster/cell_file.hpp"
#include "raytracer/core/base/scene_words.hpp"

namespace terravox::analyse {

/// The face of a cell that is a part of a facade, on the map.
struct FacadeFace {
    std::int32_t column = 0;
    std::int32_t row = 0;
    core::WallSide side = core::WallSide::kNorth;
    friend auto operator<=>(const FacadeFace&, const FacadeFace&) = default;
};

/// Which faces belong together: those of a building and a storey that look to one of eight
/// directions.
struct FacadeKey {
    std::int32_t building = 0;  ///< from 1; 0: none that the raster of the roofs shows
    Facing facing = Facing::kNorth;
    std::int32_t storey = 0;
    friend auto operator<=>(const FacadeKey&, const FacadeKey&) = default;
};

/// The faces of a facade's storey, added up.
struct FacadeFacts {
    double area_m2 = 0;
    double kwh = 0;
    double beam_kwh = 0;
    double hours_m2 = 0;         ///< hours of sun of each square metre
    double sky_m2 = 0;           ///< share of the sky of each square metre
    double east = 0, north = 0;  ///< sum of the normals of its square metres
    double bottom_m = 0;         ///< of the lowest face
    double top_m = 0;            ///< of the highest one
    std::vector<FacadeFace> faces;

    [[nodiscard]] double kwh_m2() const noexcept { return kwh / area_m2; }
    /// Mean of its square metres, clockwise from the map's north, [0, 360).
    [[nodiscard]] double azimuth_deg() const noexcept;
};

/// Gathers the facades of a raster's buildings from rasters of AnalysisKind::kFacade, one for each
/// side and storey. A function of their values alone, in the order of the storeys and sides.
class FacadeSums {
public:
    /// Of walls whose cell has no number.
    enum class Unnumbered : std::uint8_t {
        kKept,  ///< they are facades of the building 0
        kLeftOut,
    };
    explicit FacadeSums(Unnumbered unnumbered = Unnumbered::kKept) noexcept
        : m_unnumbered(unnumbered) {}

    /// What a GeoPackage is made of, in memory: twelve bytes a face.
    static constexpr std::size_t kMaxFaces = 8'000'000;

    /// Adds the walls of a side and a storey.
    /// @param buildings Int32, as large as the raster: numbers of buildings, 0 elsewhere
    /// @return whether there is any, be it left out
    /// @throws Error for more than kMaxFaces, or as CellFile; "interrupted" when stopped
    bool add(CellFile& cells, GDALDatasetH buildings, core::WallSide side, std::int32_t storey,
             const std::stop_token& stop);

    [[nodiscard]] const std::map<FacadeKey, FacadeFacts>& facts() const noexcept { return m_facts; }

private:
    const Unnumbered m_unnumbered;
    std::map<FacadeKey, FacadeFacts> m_facts;
    std::size_t m_faces = 0;
};

/// Writes facades as a GeoPackage with the layer `facades` (docs/formats/objects.md): a feature for
/// each storey of a building's facade, with the lines of its faces on the map.
/// @return how many there are
/// @throws Error
std::size_t write_facades(const FacadeSums& sums, const std::filesystem::path& out,
                          const ObjectFileInfo& info);

}  // namespace terravox::analyse
