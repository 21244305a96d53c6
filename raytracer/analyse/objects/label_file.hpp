#pragma once

#include <filesystem>
#include <string>

#include "common/util/atomic_file.hpp"
#include "raytracer/analyse/objects/connected_cells.hpp"
#include "raytracer/output/gdal_writing.hpp"

namespace terravox::analyse {

/// The numbers of buildings, cell by cell, as a temporary raster of Int32 next to an output: 0
/// where there is no building. The file is removed with the object.
class LabelFile {
public:
    /// @param out the file that is made of it
    /// @param columns, rows of the raster that was searched
    /// @throws Error when it cannot be written; "interrupted" when stopped
    LabelFile(const std::filesystem::path& out, ConnectedCells& found, int columns, int rows);

    [[nodiscard]] GDALDatasetH dataset() const noexcept { return m_dataset.get(); }

private:
    const std::string m_attempt;
    util::AtomicFile m_file;  // outlives the dataset in it; never committed
    output::GdalDataset m_dataset;
};

}  // namespace terravox::analyse
