#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "raytracer/analyse/raster/cell_file.hpp"

namespace terravox::analyse {

/// Shadow masks of several instants in a temporary file next to the output: a band of bytes for
/// each, and one that counts holes. The file is removed with the object. Not thread-safe.
class ShadowCube {
public:
    static constexpr std::uint8_t kNoMask = 255;  ///< no value: outside of the data, behind a hole

    /// @param names of the masks' bands @throws Error when it cannot be written
    ShadowCube(const std::filesystem::path& out, std::span<const std::string> names, int columns,
               int rows);

    /// Takes the mask of an instant.
    /// @param index of its name
    /// @param cells of AnalysisKind::kShadow, as many as this has @throws Error
    void take(std::size_t index, CellFile& cells);
    /// Writes the masks as a Cloud Optimized GeoTIFF. @throws Error
    void write(const std::filesystem::path& out, const output::PictureInfo& info, int threads);

private:
    void write_band(std::size_t index, const CellRectangle& area,
                    std::vector<std::uint8_t>& values);
    [[nodiscard]] std::vector<std::uint8_t> read_band(std::size_t index, const CellRectangle& area);

    const std::string m_attempt;
    const std::size_t m_masks;
    util::AtomicFile m_file;  // outlives the dataset in it; never committed
    output::GdalDataset m_dataset;
};

}  // namespace terravox::analyse
